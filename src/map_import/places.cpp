// SPDX-License-Identifier: BSD-3-Clause
#include "places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::map_import {

namespace {

// m. Chosen: storeys are more than two metres apart, and on a ramp of 15 % two places of the usual
// spacing (5 m) are less than one.
constexpr double kSameStorey = 1.0;
// Of heights among distances. Chosen: a walk leaves a storey when nothing is left of it within 10
// m.
constexpr double kHeightWeight = 4.0;

/// Positions that keep their distance from each other.
class SpacedPositions {
 public:
  explicit SpacedPositions(double spacing) : spacing_(spacing) {}

  /// Adds a position unless another one is too near; says whether it did.
  bool add(const Eigen::Vector3d& p) {
    const VoxelKey key = voxel_key(voxel_index(p / spacing_));
    bool is_free = true;
    for_voxels_around(key, [&](VoxelKey near) { is_free = is_free && !has_near(near, p); });
    if (is_free) positions_[key].push_back(p);
    return is_free;
  }

 private:
  bool has_near(VoxelKey key, const Eigen::Vector3d& p) const {
    const auto found = positions_.find(key);
    if (found == positions_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [&](const auto& other) {
      return (other - p).norm() < spacing_ && std::abs(other.z() - p.z()) < kSameStorey;
    });
  }

  double spacing_;
  std::unordered_map<VoxelKey, std::vector<Eigen::Vector3d>, VoxelKeyHash> positions_;
};

/// The order of a walk from the first one: always to the nearest that is left.
std::vector<OpenCell> in_walking_order(std::vector<OpenCell> cells) {
  const Eigen::Vector3d weights(1.0, 1.0, kHeightWeight);
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const Eigen::Vector3d here = cells[i - 1].p_map;
    std::size_t nearest = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = i; k < cells.size(); ++k) {
      const double distance = (cells[k].p_map - here).cwiseProduct(weights).squaredNorm();
      if (distance >= least) continue;
      least = distance;
      nearest = k;
    }
    std::swap(cells[i], cells[nearest]);
  }
  return cells;
}

Stamp second(std::size_t number) { return static_cast<Stamp>(number) * kNanosecondsPerSecond; }

}  // namespace

std::vector<Place> places_on_ground(const std::vector<OpenCell>& ground, double spacing,
                                    double base_height) {
  std::vector<std::size_t> order(ground.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return ground[a].clearance > ground[b].clearance;
  });
  SpacedPositions spaced(spacing);
  std::vector<OpenCell> taken;
  for (const std::size_t i : order) {
    if (spaced.add(ground[i].p_map)) taken.push_back(ground[i]);
  }
  std::vector<Place> places;
  const auto walk = in_walking_order(std::move(taken));
  for (const OpenCell& cell : walk) {
    Place place;
    place.stamp = second(places.size() + 1);
    place.T_map_base.rotation =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), cell.up);
    place.T_map_base.translation = cell.p_map + base_height * cell.up;
    places.push_back(place);
  }
  return places;
}

std::vector<Place> places_along(const Trajectory& trajectory, double spacing) {
  SpacedPositions spaced(spacing);
  std::vector<Place> places;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const StampedPose& pose = trajectory.poses[i];
    const Stamp stamp = trajectory.has_stamps ? pose.stamp : second(i + 1);
    const bool is_repeated = !places.empty() && stamp <= places.back().stamp;
    if (is_repeated || !spaced.add(pose.pose.translation)) continue;
    places.push_back({stamp, pose.pose});
  }
  return places;
}

}  // namespace lidar_mapping::map_import
