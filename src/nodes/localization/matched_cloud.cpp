// SPDX-License-Identifier: BSD-3-Clause
#include "localization/matched_cloud.hpp"

#include "lidar_mapping/ros/cloud_conversions.hpp"

namespace lidar_mapping::ros_border {

/// On the wire the agreement lies where the intensity of other clouds does.
sensor_msgs::PointCloud2 matched_cloud(const std::vector<localization::MatchedPoint>& points,
                                       const Pose& T_map_base, Stamp stamp,
                                       const std::string& map_frame) {
  PointCloud cloud;
  cloud.points.reserve(points.size());
  for (const localization::MatchedPoint& point : points) {
    const Eigen::Vector3f p_map = (T_map_base * point.p_base.cast<double>()).cast<float>();
    cloud.points.push_back({p_map.x(), p_map.y(), p_map.z(), point.agreement});
  }
  sensor_msgs::PointCloud2 message = to_message(cloud, stamp, map_frame);
  message.fields.back().name = "agreement";
  return message;
}

}  // namespace lidar_mapping::ros_border
