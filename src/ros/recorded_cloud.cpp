// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Bytes, by the format of sensor_msgs/PointField: an empty name, offset, datatype and count.
constexpr std::uint32_t kShortestField = 4 + 4 + 1 + 4;

/// Not by the library, which allocates the number of fields before it checks that the data have
/// them, so that a damaged number could exhaust the memory.
void read_fields(ros::serialization::IStream& stream,
                 std::vector<sensor_msgs::PointField>& fields) {
  std::uint32_t count = 0;
  stream.next(count);
  if (count > stream.getLength() / kShortestField) ros::serialization::throwStreamOverrun();
  fields.resize(count);
  for (sensor_msgs::PointField& field : fields) stream.next(field);
}

}  // namespace

RecordedCloud read_cloud(const BagMessage& recorded) {
  RecordedCloud cloud;
  sensor_msgs::PointCloud2& message = cloud.message;
  ros::serialization::IStream stream = recorded.stream();
  stream.next(message.header);
  stream.next(message.height);
  stream.next(message.width);
  read_fields(stream, message.fields);
  stream.next(message.is_bigendian);
  stream.next(message.point_step);
  stream.next(message.row_step);
  std::uint32_t length = 0;
  stream.next(length);
  cloud.data = {stream.advance(length), length};
  cloud.memory = recorded.memory;
  return cloud;
}

}  // namespace lidar_mapping::ros_border
