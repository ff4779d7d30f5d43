#include "voxel_target.hpp"

#include <algorithm>
#include <vector>

namespace lidar_mapping::registration {

namespace {

Eigen::Vector3d middle_of(const PclCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const pcl::PointXYZ& p : cloud) sum += p.getVector3fMap().cast<double>();
  return sum / static_cast<double>(cloud.size());
}

}  // namespace

GaussianVoxelMap voxel_target(const PclCloud& cloud, double resolution, const PlaneModel& model) {
  constexpr std::size_t kLeastCapacity = 1024;
  // Half of the table stays empty even if every point has a voxel of its own.
  GaussianVoxelMap map(resolution, std::max(kLeastCapacity, 2 * cloud.size()), model);
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
