// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/display_map.hpp"

#include <algorithm>

namespace lidar_mapping::map {

namespace {

// m; by definition: the largest edge of voxels that MapConfig allows.
constexpr double kLargestVoxel = 10.0;
// Key frames after which the points are counted, so that a long drive that is resumed is not in
// memory with small voxels first. Chosen: some 90 MB of points.
constexpr std::size_t kCountAfter = 2000;

}  // namespace

double display_resolution(std::size_t gaussians) {
  constexpr double kSmallest = 0.5;         // m; chosen: a town of 1 km then has some 10 MB
  constexpr double kPointsPerGaussian = 6;  // measured in a town, with voxels of 0.5 m
  constexpr auto kMostPoints = static_cast<double>(kMostDisplayPoints);
  double edge = kSmallest;
  double points = kPointsPerGaussian * static_cast<double>(gaussians);
  for (; points > kMostPoints; points /= 4.0) edge *= 2.0;  // surfaces: by the square of the edge
  return edge;
}

DisplayMap::DisplayMap(const MapConfig& config, CloudSource& clouds, std::size_t most_points)
    : config_(config), clouds_(clouds), most_points_(most_points) {
  builder_.emplace(config_, clouds_);
}

bool DisplayMap::update(const KeyFramePoses& poses) {
  poses_ = poses;
  const std::uint64_t before = builder_->revision();
  given_ = std::min(given_, poses_.poses.size());
  give_poses();
  return builder_->revision() != before || given_ < poses_.poses.size();
}

PointCloud DisplayMap::build() {
  PointCloud cloud;
  do {
    given_ = std::min(given_ + kCountAfter, poses_.poses.size());
    give_poses();
    cloud = builder_->build();
    if (cloud.size() > most_points_ && 2.0 * config_.resolution <= kLargestVoxel)
      begin_with_larger_voxels();
  } while (given_ < poses_.poses.size());
  return cloud;
}

void DisplayMap::give_poses() {
  KeyFramePoses part = poses_;
  part.poses.resize(given_);
  part.whole = true;
  builder_->update(part);
}

/// All clouds are read again, which happens at most a few times in the longest drive.
void DisplayMap::begin_with_larger_voxels() {
  config_.resolution *= 2.0;
  builder_.reset();  // first, because one map needs memory enough
  builder_.emplace(config_, clouds_);
  given_ = 0;
}

}  // namespace lidar_mapping::map
