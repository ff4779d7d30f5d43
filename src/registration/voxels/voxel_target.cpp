// SPDX-License-Identifier: BSD-3-Clause
#include "voxels/voxel_target.hpp"

#include <algorithm>
#include <vector>

#include "lidar_mapping/common/voxel_filter.hpp"

namespace lidar_mapping::registration {

namespace {

/// Number of voxels that hold points.
std::size_t voxel_count(const PclCloud& cloud, double resolution) {
  PointCloud points;
  points.points.reserve(cloud.size());
  for (const pcl::PointXYZ& p : cloud) points.points.push_back({p.x, p.y, p.z, 0.0F});
  return voxel_filtered(points, resolution).size();
}

}  // namespace

GaussianVoxelMap voxel_target(const PclCloud& cloud, double resolution, const PlaneModel& model) {
  constexpr std::size_t kLeastCapacity = 1024;  // slots; chosen, for clouds of a few points
  // Half of the table stays empty.
  GaussianVoxelMap map(resolution, std::max(kLeastCapacity, 2 * voxel_count(cloud, resolution)),
                       model);
  map.set_origin_cell((middle_of(cloud) / resolution).array().round().matrix().cast<int>());
  const Eigen::Vector3d origin = map.origin();
  std::vector<float> x, y, z;
  for (const pcl::PointXYZ& p : cloud) {
    x.push_back(static_cast<float>(p.x - origin.x()));
    y.push_back(static_cast<float>(p.y - origin.y()));
    z.push_back(static_cast<float>(p.z - origin.z()));
  }
  map.insert(x.data(), y.data(), z.data(), x.size());
  return map;
}

}  // namespace lidar_mapping::registration
