// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/recorded_cloud.hpp"

#include <utility>

#include <sensor_msgs/PointCloud.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"

#include "bags/wire_array.hpp"
#include "clouds/driver_messages.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Bytes, by the format of sensor_msgs/PointField: an empty name, offset, datatype and count.
constexpr std::uint32_t kShortestField = 4 + 4 + 1 + 4;

RecordedCloud read_point_cloud2(ros::serialization::IStream stream) {
  RecordedCloud cloud;
  sensor_msgs::PointCloud2& message = cloud.message;
  stream.next(message.header);
  stream.next(message.height);
  stream.next(message.width);
  message.fields.resize(array_length(stream, kShortestField));
  for (sensor_msgs::PointField& field : message.fields) stream.next(field);
  stream.next(message.is_bigendian);
  stream.next(message.point_step);
  stream.next(message.row_step);
  cloud.data = array_bytes(stream);
  return cloud;
}

template <PacketLayout layout>
RecordedCloud read_pandar(ros::serialization::IStream stream) {
  return read_pandar_scan(stream, layout);
}

/// A type of message with one of its definitions, and how a cloud is read from it.
struct Reader {
  CloudType type;
  RecordedCloud (*read)(ros::serialization::IStream stream);
};

/// All code that has to know the types uses this table. Of several definitions of a type the first
/// is that of ROS 2.
const std::vector<Reader>& readers() {
  using ros::message_traits::MD5Sum;
  // The MD5 sums of types of drivers are those of the packages' message definitions.
  static const std::string livox = "e4d6829bdfe657cb6c21a746c86b21a6";
  static const std::vector<Reader> all = {
      {{"sensor_msgs/PointCloud2", MD5Sum<sensor_msgs::PointCloud2>::value()}, read_point_cloud2},
      {{"livox_ros_driver/CustomMsg", livox}, read_livox_cloud},
      {{"livox_ros_driver2/CustomMsg", livox}, read_livox_cloud},
      {{"velodyne_msgs/VelodyneScan", "50804fc9533a0e579e6322c04ae70566"}, read_velodyne_scan},
      {{"hesai_lidar/PandarScan", kPandarScanInSizes}, read_pandar<PacketLayout::kHesaiInSizes>},
      {{"hesai_lidar/PandarScan", kPandarScanInPlaces}, read_pandar<PacketLayout::kHesaiInPlaces>},
      {{"pandar_msgs/PandarScan", kPandarScanInPlaces}, read_pandar<PacketLayout::kHesaiInPlaces>},
      {{"pandar_msgs/PandarScan", kPandarScanInSizes}, read_pandar<PacketLayout::kHesaiInSizes>},
      {{"sensor_msgs/PointCloud", MD5Sum<sensor_msgs::PointCloud>::value()}, read_point_cloud1}};
  return all;
}

std::vector<CloudType> types() {
  std::vector<CloudType> types;
  for (const Reader& reader : readers()) types.push_back(reader.type);
  return types;
}

}  // namespace

const std::vector<CloudType>& cloud_types() {
  static const std::vector<CloudType> all = types();
  return all;
}

RecordedCloud read_cloud(const std::string& type, const std::string& md5sum, ByteRange data,
                         std::shared_ptr<const void> memory) {
  for (const Reader& reader : readers()) {
    if (type != reader.type.name || md5sum != reader.type.md5sum) continue;
    RecordedCloud cloud = reader.read(stream_of(data));
    if (!cloud.memory) cloud.memory = std::move(memory);
    return cloud;
  }
  throw InputError("no cloud is read from " + type);
}

std::optional<RecordedCloud> read_cloud(const BagMessage& recorded) {
  if (!is_cloud(recorded.getDataType(), recorded.connection->md5sum)) return std::nullopt;
  return read_cloud(recorded.getDataType(), recorded.connection->md5sum, recorded.data,
                    recorded.memory);
}

}  // namespace lidar_mapping::ros_border
