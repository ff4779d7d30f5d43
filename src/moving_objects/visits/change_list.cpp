// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/change_list.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::moving_objects {

namespace {

using Voxel = std::array<int, 3>;
using Voxels = std::map<Voxel, std::uint32_t>;

/// The visit that is nearer in time to the one in which the location was empty.
std::uint32_t nearer(ChangeKind kind, std::uint32_t a, std::uint32_t b) {
  return kind == ChangeKind::kAppeared ? std::min(a, b) : std::max(a, b);
}

/// Adds a voxel that was occupied in this visit.
void add_voxel(Voxels& voxels, const Voxel& voxel, ChangeKind kind, std::uint32_t visit) {
  const auto [known, is_new] = voxels.emplace(voxel, visit);
  if (!is_new) known->second = nearer(kind, known->second, visit);
}

/// Takes a voxel and all that touch it, directly or by others, out of `voxels`.
Voxels taken_connected(Voxels& voxels) {
  Voxels taken;
  std::vector<Voxel> next = {voxels.begin()->first};
  while (!next.empty()) {
    const auto [x, y, z] = next.back();
    next.pop_back();
    const auto found = voxels.find({x, y, z});
    if (found == voxels.end()) continue;
    taken.insert(*found);
    voxels.erase(found);
    for (int n = 0; n < 27; ++n) {
      next.push_back({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
    }
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
  for (const auto& [voxel, visit] : voxels) {
    const Eigen::Vector3d low = ChangeList::kVoxel * Eigen::Vector3d(voxel[0], voxel[1], voxel[2]);
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
  const VoxelIndex voxel = voxel_index(p_map / kVoxel);
  add_voxel(voxels_[{change.absent, change.kind}], {voxel.x(), voxel.y(), voxel.z()}, change.kind,
            change.present);
}

void ChangeList::add(const ChangeList& other) {
  for (const auto& [what, voxels] : other.voxels_) {
    for (const auto& [voxel, visit] : voxels) add_voxel(voxels_[what], voxel, what.second, visit);
  }
}

std::vector<Change> ChangeList::changes() const {
  std::vector<Change> changes;
  for (auto [what, voxels] : voxels_) {
    while (!voxels.empty()) {
      Change change = change_of(taken_connected(voxels), what.second, what.first);
      if (is_listed(change)) changes.push_back(std::move(change));
    }
  }
  return changes;
}

}  // namespace lidar_mapping::moving_objects
