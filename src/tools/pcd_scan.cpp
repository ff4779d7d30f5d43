#include "pcd_scan.hpp"

#include <fstream>

#include <pcl/io/pcd_io.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

namespace lidar_mapping::tools {

namespace {

/// More than x y z intensity, which need no decoder. PCL's reader crashes on files whose header was
/// cut off; they count as plain, and the session's reader refuses them.
bool has_more_fields(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  bool has_more = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("DATA", 0) == 0) return has_more;
    if (line.rfind("FIELDS ", 0) == 0) {
      has_more = line != "FIELDS x y z" && line != "FIELDS x y z intensity";
    }
  }
  return false;
}

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
  if (!has_more_fields(path)) return {stamp, "", session::read_pcd(path)};
  pcl::PCLPointCloud2 cloud;
  if (pcl::PCDReader().read(path, cloud) < 0) {
    throw FileError("cannot read " + path + ": missing or damaged PCD file");
  }
  return ros_border::decode(to_message(cloud, stamp), config).scan;
}

}  // namespace lidar_mapping::tools
