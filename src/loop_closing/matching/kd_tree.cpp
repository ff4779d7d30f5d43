// SPDX-License-Identifier: BSD-3-Clause
#include "matching/kd_tree.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <nanoflann.hpp>

namespace lidar_mapping::loop_closing {

namespace {

// Points. Measured on submaps of the simulated town: 24 is the best of 6, 10 (nanoflann's default),
// 16 and 24.
constexpr std::size_t kLeafSize = 24;
constexpr int kAxes = 3;  // x, y, z, by geometry

/// Points as nanoflann reads them.
struct PointSet {
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // nanoflann computes it
  }

  std::vector<Eigen::Vector3f> points;
};

using Metric = nanoflann::L2_Simple_Adaptor<float, PointSet>;
using Tree = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, kAxes, std::uint32_t>;
using NearestPoints = nanoflann::KNNResultSet<float, std::uint32_t>;

/// The `kCount` nearest points of those that are closer than a limit.
template <std::size_t kCount>
class NearestWithin : public NearestPoints {
 public:
  explicit NearestWithin(float limit) : NearestPoints(kCount), squared_limit_(limit * limit) {
    init(indices_.data(), squared_distances_.data());
  }
  NearestWithin(const NearestWithin&) = delete;  // the base points into the arrays
  NearestWithin& operator=(const NearestWithin&) = delete;

  /// nanoflann passes by what is not closer.
  float worstDist() const { return std::min(squared_limit_, NearestPoints::worstDist()); }
  KdTree::Neighbour nearest() const { return {indices_[0], squared_distances_[0]}; }
  /// Of the last point; the limit if there are fewer points.
  float last_squared_distance() const {
    return full() ? squared_distances_[kCount - 1] : squared_limit_;
  }

 private:
  float squared_limit_;
  std::array<std::uint32_t, kCount> indices_;
  std::array<float, kCount> squared_distances_;
};

}  // namespace

struct KdTree::Index {
  explicit Index(std::vector<Eigen::Vector3f> points)
      : set{std::move(points)},
        tree(kAxes, set, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
#if NANOFLANN_VERSION < 0x140  // Ubuntu 20.04; later versions build the tree in its constructor
    tree.buildIndex();
#endif
  }

  PointSet set;
  Tree tree;
};

KdTree::KdTree() : KdTree(std::vector<Eigen::Vector3f>()) {}

KdTree::KdTree(std::vector<Eigen::Vector3f> points)
    : index_(std::make_unique<const Index>(std::move(points))) {}

KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;
KdTree::~KdTree() = default;

const std::vector<Eigen::Vector3f>& KdTree::points() const { return index_->set.points; }

std::optional<KdTree::Neighbour> KdTree::nearest(const Eigen::Vector3f& p, float limit) const {
  NearestWithin<1> found(limit);
  index_->tree.findNeighbors(found, p.data(), {});
  if (found.size() == 0) return std::nullopt;
  return found.nearest();
}

std::optional<KdTree::NearestWithSecond> KdTree::nearest_with_second(const Eigen::Vector3f& p,
                                                                     float limit) const {
  NearestWithin<2> found(limit);
  index_->tree.findNeighbors(found, p.data(), {});
  if (found.size() == 0) return std::nullopt;
  return NearestWithSecond{found.nearest(), found.last_squared_distance()};
}

std::vector<KdTree::Neighbour> KdTree::nearest(const Eigen::Vector3f& p, std::size_t count) const {
  if (count == 0) return {};  // nanoflann would read before its arrays
  std::vector<std::uint32_t> indices(count);
  std::vector<float> squared_distances(count);
  const std::size_t found =
      index_->tree.knnSearch(p.data(), count, indices.data(), squared_distances.data());
  std::vector<Neighbour> neighbours(found);
  for (std::size_t i = 0; i < found; ++i) neighbours[i] = {indices[i], squared_distances[i]};
  return neighbours;
}

}  // namespace lidar_mapping::loop_closing
