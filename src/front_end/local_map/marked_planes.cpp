// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/marked_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::front_end {
namespace {

using Indices = std::vector<std::size_t>;

/// A plane with fewer marked points is not looked for. Chosen: three suffice for a plane, and a few
/// more lie on it by chance.
constexpr std::size_t kMinMarked = 12;
/// Distance within which a point lies on a plane, m. Chosen: five standard deviations of a range,
/// and what the side of a truck is bent by.
constexpr float kThickness = 0.15F;
/// Planes through three of the marked points that are tried. Chosen: if only a third of the marked
/// points lies on one plane, one of so many draws is of that plane with 0.91.
constexpr int kDraws = 64;
/// The triangle of such three points has at least twice this area, m^2. Chosen: with its sides of
/// half a metre, the plane is known to kThickness a few metres away.
constexpr float kMinArea = 0.3F;
/// Points are connected if they lie in the same or in adjacent squares of this edge, m. Chosen: at
/// the end of a truck the samples of a ring lie up to a metre apart.
constexpr float kSquare = 1.5F;
/// Fraction of a plane's points that is marked. Chosen: measured fractions are below 0.01 where
/// nothing moves, and of a truck alongside a tenth is where nothing was after two metres.
constexpr double kMinFraction = 0.1;

class Plane {
 public:
  Plane(const Eigen::Vector3f& point, const Eigen::Vector3f& normal)
      : normal_(normal),
        offset_(normal.dot(point)),
        u_(normal.unitOrthogonal()),
        v_(normal.cross(u_)) {}

  bool holds(const Eigen::Vector3f& p) const {
    return std::abs(normal_.dot(p) - offset_) < kThickness;
  }
  VoxelKey square_of(const Eigen::Vector3f& p) const {
    return voxel_key({floor_to_int(u_.dot(p) / kSquare), floor_to_int(v_.dot(p) / kSquare), 0});
  }

 private:
  Eigen::Vector3f normal_;
  float offset_;       ///< m, along the normal
  Eigen::Vector3f u_;  ///< in the plane, as v_
  Eigen::Vector3f v_;
};

Indices points_on(const Plane& plane, const SampledPoints& points, const Indices& among) {
  Indices found;
  for (const std::size_t i : among) {
    if (plane.holds(points.position(i))) found.push_back(i);
  }
  return found;
}

/// The plane that holds most of the points, by random samples (Fischler, Bolles 1981); none if they
/// lie on a line. The numbers are the same in each call, so that equal scans give equal results.
std::optional<Plane> largest_plane(const SampledPoints& points, const Indices& among) {
  std::optional<Plane> largest;
  std::size_t most = 0;
  std::uint64_t draw = 0;
  const auto next = [&] {
    return points.position(among[(fibonacci_hash(++draw) >> 32U) % among.size()]);
  };
  for (int k = 0; k < kDraws; ++k) {
    const Eigen::Vector3f a = next(), b = next(), c = next();
    const Eigen::Vector3f normal = (b - a).cross(c - a);
    if (normal.norm() < kMinArea) continue;
    const Plane plane(a, normal.normalized());
    const std::size_t count = points_on(plane, points, among).size();
    if (count <= most) continue;
    most = count;
    largest = plane;
  }
  return largest;
}

/// The points on the plane that are connected with the given ones.
Indices connected_points(const Plane& plane, const SampledPoints& points, const Indices& from) {
  std::unordered_map<VoxelKey, Indices, VoxelKeyHash> squares;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points.position(i);
    if (plane.holds(p)) squares[plane.square_of(p)].push_back(i);
  }
  Indices connected;
  std::vector<VoxelKey> open;
  const auto reach = [&](VoxelKey key) {
    const auto square = squares.find(key);
    if (square == squares.end()) return;
    connected.insert(connected.end(), square->second.begin(), square->second.end());
    open.push_back(key);
    squares.erase(square);
  };
  for (const std::size_t i : from) reach(plane.square_of(points.position(i)));
  while (!open.empty()) {
    const VoxelKey key = open.back();
    open.pop_back();
    for_voxels_around(key, reach);
  }
  return connected;
}

}  // namespace

void mark_planes(const SampledPoints& points, PointMarks& marks) {
  Indices marked;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i] != 0) marked.push_back(i);
  }
  while (marked.size() >= kMinMarked) {
    const std::optional<Plane> plane = largest_plane(points, marked);
    if (!plane) return;
    const Indices on_plane = points_on(*plane, points, marked);
    if (on_plane.size() < kMinMarked) return;
    const Indices connected = connected_points(*plane, points, on_plane);
    if (static_cast<double>(on_plane.size()) >=
        kMinFraction * static_cast<double>(connected.size())) {
      for (const std::size_t i : connected) marks[i] = 1;
    }
    marked.erase(std::remove_if(marked.begin(), marked.end(),
                                [&](std::size_t i) { return plane->holds(points.position(i)); }),
                 marked.end());
  }
}

}  // namespace lidar_mapping::front_end
