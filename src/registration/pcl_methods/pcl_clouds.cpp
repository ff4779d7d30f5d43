// SPDX-License-Identifier: BSD-3-Clause
#include "pcl_methods/pcl_clouds.hpp"

#include <cmath>

namespace lidar_mapping::registration {

PclCloud::Ptr to_pcl(const PointCloud& cloud) {
  PclCloud::Ptr result(new PclCloud);
  result->reserve(cloud.size());
  for (const Point& p : cloud.points) {
    if (std::isfinite(p.x + p.y + p.z)) result->push_back(pcl::PointXYZ(p.x, p.y, p.z));
  }
  return result;
}

Eigen::Vector3d middle_of(const PclCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  if (cloud.empty()) return sum;
  for (const pcl::PointXYZ& p : cloud) sum += p.getVector3fMap().cast<double>();
  return sum / static_cast<double>(cloud.size());
}

}  // namespace lidar_mapping::registration
