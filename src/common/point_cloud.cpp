// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

PointCloud transformed(const PointCloud& cloud, const Pose& T_a_b) {
  const Eigen::Matrix3f R = T_a_b.rotation_matrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation.cast<float>();
  PointCloud result;
  result.points.resize(cloud.size());
  result.times = cloud.times;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = R * cloud.points[i].position() + t;
    result.points[i] = {p.x(), p.y(), p.z(), cloud.points[i].intensity};
  }
  return result;
}

}  // namespace lidar_mapping
