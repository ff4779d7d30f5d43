// SPDX-License-Identifier: BSD-3-Clause
#include "kd_tree.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace lidar_mapping::loop_closing {

namespace {

// Points. Chosen: larger leaves measure more points in vain, smaller ones descend further.
constexpr std::uint32_t kLeafSize = 16;
constexpr std::uint32_t kLanes = 4;  // floats of a vector that every processor has
constexpr int kAxes = 3;             // x, y, z, by geometry

using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));

using Iterator = std::vector<Eigen::Vector3f>::iterator;

inline Lanes load(const float* values) {
  Lanes lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}

int widest_axis(Iterator begin, Iterator end) {
  Eigen::Vector3f low = *begin;
  Eigen::Vector3f high = *begin;
  for (Iterator p = begin; p != end; ++p) {
    low = low.cwiseMin(*p);
    high = high.cwiseMax(*p);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

// The visitors below are called only for points that are closer than their limit.

/// Keeps the nearest point.
struct NearestOne {
  float squared_limit;
  std::uint32_t index = 0;
  bool found = false;

  void operator()(std::uint32_t candidate, float squared_distance) {
    squared_limit = squared_distance;
    index = candidate;
    found = true;
  }
};

/// Keeps the nearest point and the distance of the second one.
struct NearestTwo {
  float squared_limit;  // of the second
  float nearest = squared_limit;
  std::uint32_t index = 0;
  bool found = false;

  void operator()(std::uint32_t candidate, float squared_distance) {
    squared_limit = squared_distance;
    if (squared_distance >= nearest) return;
    squared_limit = nearest;
    nearest = squared_distance;
    index = candidate;
    found = true;
  }
};

/// Keeps several nearest points, sorted by distance.
struct NearestSeveral {
  std::size_t count;
  float squared_limit = std::numeric_limits<float>::infinity();
  std::vector<KdTree::Neighbour> kept = {};

  void operator()(std::uint32_t candidate, float squared_distance) {
    if (kept.size() < count) kept.emplace_back();
    auto position = kept.end() - 1;
    for (; position != kept.begin() && squared_distance < (position - 1)->squared_distance;
         --position) {
      *position = *(position - 1);
    }
    *position = {candidate, squared_distance};
    if (kept.size() == count) squared_limit = kept.back().squared_distance;
  }
};

}  // namespace

KdTree::KdTree(std::vector<Eigen::Vector3f> points) : points_(std::move(points)) {
  if (points_.empty()) return;
  build(0, static_cast<std::uint32_t>(points_.size()));
  for (int axis = 0; axis < kAxes; ++axis) {
    coordinates_[axis].reserve(points_.size() + kLanes);
    for (const Eigen::Vector3f& p : points_) coordinates_[axis].push_back(p[axis]);
    coordinates_[axis].resize(points_.size() + kLanes);
  }
}

std::uint32_t KdTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({begin, end, 0, 0, 0.0F});
  if (end - begin <= kLeafSize) return self;
  const auto first = points_.begin();
  const int axis = widest_axis(first + begin, first + end);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      first + begin, first + middle, first + end,
      [axis](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a[axis] < b[axis]; });
  nodes_[self].axis = axis;
  nodes_[self].split = points_[middle][axis];
  build(begin, middle);
  const std::uint32_t right = build(middle, end);
  nodes_[self].right = right;
  return self;
}

// The last lanes may belong to the next leaf and are ignored.
template <typename Visit>
inline void KdTree::scan_leaf(const Node& leaf, const Eigen::Vector3f& p, Visit& visit) const {
  const std::uint32_t count = leaf.end - leaf.begin;
  std::array<float, kLeafSize> squared;
  for (std::uint32_t i = 0; i < count; i += kLanes) {
    const Lanes x = load(&coordinates_[0][leaf.begin + i]) - p.x();
    const Lanes y = load(&coordinates_[1][leaf.begin + i]) - p.y();
    const Lanes z = load(&coordinates_[2][leaf.begin + i]) - p.z();
    const Lanes lanes = x * x + (y * y + z * z);  // in the order of Eigen's squaredNorm()
    std::memcpy(&squared[i], &lanes, sizeof(lanes));
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (squared[i] < visit.squared_limit) visit(leaf.begin + i, squared[i]);
  }
}

// `offset` is the vector from p to the cell of the node. Its length is a lower bound for the
// distances of all points in the cell (Arya and Mount 1993).
template <typename Visit>
void KdTree::search(std::uint32_t index, const Eigen::Vector3f& p, Eigen::Vector3f& offset,
                    Visit& visit) const {
  const Node& node = nodes_[index];
  if (node.right == 0) return scan_leaf(node, p, visit);
  const float side = p[node.axis] - node.split;
  const std::uint32_t near = side < 0.0F ? index + 1 : node.right;
  const std::uint32_t far = side < 0.0F ? node.right : index + 1;
  search(near, p, offset, visit);
  const float kept = offset[node.axis];
  offset[node.axis] = side;
  if (offset.squaredNorm() < visit.squared_limit) search(far, p, offset, visit);
  offset[node.axis] = kept;
}

template <typename Visit>
void KdTree::search(const Eigen::Vector3f& p, Visit& visit) const {
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();
  if (!nodes_.empty()) search(0, p, offset, visit);
}

std::optional<KdTree::Neighbour> KdTree::nearest(const Eigen::Vector3f& p, float limit) const {
  NearestOne visit{limit * limit};
  search(p, visit);
  if (!visit.found) return std::nullopt;
  return Neighbour{visit.index, visit.squared_limit};
}

std::optional<KdTree::NearestWithSecond> KdTree::nearest_with_second(const Eigen::Vector3f& p,
                                                                     float limit) const {
  NearestTwo visit{limit * limit};
  search(p, visit);
  if (!visit.found) return std::nullopt;
  return NearestWithSecond{{visit.index, visit.nearest}, visit.squared_limit};
}

std::vector<KdTree::Neighbour> KdTree::nearest(const Eigen::Vector3f& p, std::size_t count) const {
  if (count == 0) return {};
  NearestSeveral visit{count};
  visit.kept.reserve(count);
  search(p, visit);
  return std::move(visit.kept);
}

}  // namespace lidar_mapping::loop_closing
