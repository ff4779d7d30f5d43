// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/change_list.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::moving_objects {

namespace {

using Voxels = std::map<VoxelKey, std::uint32_t>;

/// The visit that is nearer in time to the one in which the location was empty.
std::uint32_t nearer(ChangeKind kind, std::uint32_t a, std::uint32_t b) {
  return kind == ChangeKind::kAppeared ? std::min(a, b) : std::max(a, b);
}

/// Takes a voxel and all that touch it, directly or by others, out of `voxels`.
Voxels taken_connected(Voxels& voxels) {
  Voxels taken;
  std::vector<VoxelKey> next = {voxels.begin()->first};
  while (!next.empty()) {
    const VoxelKey key = next.back();
    next.pop_back();
    const auto found = voxels.find(key);
    if (found == voxels.end()) continue;
    taken.insert(*found);
    voxels.erase(found);
    for_voxels_around(key, [&](VoxelKey neighbour) { next.push_back(neighbour); });
  }
  return taken;
}

Eigen::Vector2d mean_of(const PointCloud& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Point& point : points.points) sum += point.position().head<2>().cast<double>();
  return sum / static_cast<double>(points.size());
}

Change change_of(const Voxels& voxels, ChangeKind kind, std::uint32_t absent) {
  Change change{kind, absent, voxels.begin()->second, {}, {}, {}};
  Eigen::AlignedBox3d box;
  for (const auto& [key, visit] : voxels) {
    const Eigen::Vector3d low = ChangeList::kVoxel * voxel_index(key).cast<double>();
    box.extend(low).extend((low.array() + ChangeList::kVoxel).matrix());
    const Eigen::Vector3f centre = (low.array() + 0.5 * ChangeList::kVoxel).cast<float>();
    change.points.points.push_back({centre.x(), centre.y(), centre.z(), 0.0F});
    change.present = nearer(kind, change.present, visit);
  }
  change.low = box.min();
  change.high = box.max();
  return change;
}

/// Width of a change seen from above, across its longest direction, m: that of an even
/// distribution with the same variance.
double width_of(const Change& change) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  const Eigen::Vector2d centre = mean_of(change.points);
  for (const Point& point : change.points.points) {
    const Eigen::Vector2d d = point.position().head<2>().cast<double>() - centre;
    sum += d * d.transpose();
  }
  const Eigen::Matrix2d covariance = sum / static_cast<double>(change.points.size());
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  return std::sqrt(12.0 * std::max(0.0, least)) + ChangeList::kVoxel;
}

/// Level lines are left out: the edge of a roof, of a wall or of a kerb that one visit saw and
/// another one missed.
bool is_listed(const Change& change) {
  if (change.points.size() < ChangeList::kLeastVoxels) return false;
  return change.high.z() - change.low.z() >= ChangeList::kLeastExtent ||
         width_of(change) >= ChangeList::kLeastExtent;
}

}  // namespace

const char* to_string(ChangeKind kind) {
  return kind == ChangeKind::kAppeared ? "appeared" : "disappeared";
}

void ChangeList::add(const Eigen::Vector3d& p_map, const PointChange& change) {
  const VoxelKey key = voxel_key(voxel_index(p_map / kVoxel));
  const auto [voxel, is_new] = voxels_[{change.absent, change.kind}].emplace(key, change.present);
  if (!is_new) voxel->second = nearer(change.kind, voxel->second, change.present);
}

void ChangeList::add(const ChangeList& other) {
  for (const auto& [kind, voxels] : other.voxels_) {
    Voxels& own = voxels_[kind];
    for (const auto& [key, visit] : voxels) {
      const auto [voxel, is_new] = own.emplace(key, visit);
      if (!is_new) voxel->second = nearer(kind.kind, voxel->second, visit);
    }
  }
}

std::vector<Change> ChangeList::changes() const {
  std::vector<Change> changes;
  for (auto [kind, voxels] : voxels_) {
    while (!voxels.empty()) {
      Change change = change_of(taken_connected(voxels), kind.kind, kind.absent);
      if (is_listed(change)) changes.push_back(std::move(change));
    }
  }
  return changes;
}

}  // namespace lidar_mapping::moving_objects
