// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_scan.hpp"

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/pcd_header.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/session/cloud_store.hpp"
#include "lidar_mapping/session/pcd_points.hpp"

namespace lidar_mapping::recordings {

namespace {

/// The same layout under other names; the numbers of the datatypes are the same.
sensor_msgs::PointCloud2 to_message(const pcl::PCLPointCloud2& cloud, Stamp stamp) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = ros_border::to_ros(stamp);
  message.width = cloud.width;
  message.height = cloud.height;
  message.point_step = cloud.point_step;
  message.row_step = cloud.row_step;
  message.is_bigendian = cloud.is_bigendian != 0;
  for (const pcl::PCLPointField& from : cloud.fields) {
    sensor_msgs::PointField field;
    field.name = from.name;
    field.offset = from.offset;
    field.datatype = from.datatype;
    field.count = from.count;
    message.fields.push_back(field);
  }
  message.data.assign(cloud.data.begin(), cloud.data.end());
  return message;
}

}  // namespace

preprocessing::RawScan read_pcd_scan(const std::string& path, Stamp stamp,
                                     const preprocessing::PreprocessingConfig& config) {
  const PcdHeader header = read_pcd_header(path);
  if (!header.has_more_fields() || header.points == 0) return {stamp, "", session::read_pcd(path)};
  const pcl::PCLPointCloud2 cloud = session::read_pcd_points(path, header);
  return ros_border::decode(to_message(cloud, stamp), config).scan;
}

}  // namespace lidar_mapping::recordings
