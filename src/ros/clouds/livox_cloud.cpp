// SPDX-License-Identifier: BSD-3-Clause
#include "bags/wire_array.hpp"
#include "clouds/driver_messages.hpp"
#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

// By the formats of livox_ros_driver/CustomMsg and CustomPoint.
constexpr std::uint32_t kPoint = 19;          // bytes of a point
constexpr std::uint32_t kBase = 8;            // bytes: timebase
constexpr std::uint32_t kCounts = 4 + 1 + 3;  // bytes: point_num, lidar_id, reserved ones

}  // namespace

RecordedCloud read_livox_cloud(ros::serialization::IStream stream) {
  using sensor_msgs::PointField;
  RecordedCloud cloud;
  stream.next(cloud.message.header);
  // The stamp is that of the first point, as the time base is, by the clock of the header.
  stream.advance(kBase + kCounts);
  cloud.data = array_bytes(stream, kPoint);
  set_layout(cloud.message,
             {{"offset_time", PointField::UINT32, 0},
              {"x", PointField::FLOAT32, 4},
              {"y", PointField::FLOAT32, 8},
              {"z", PointField::FLOAT32, 12},
              {"reflectivity", PointField::UINT8, 16},
              {"tag", PointField::UINT8, 17},
              {"line", PointField::UINT8, 18}},
             kPoint, static_cast<std::uint32_t>(cloud.data.size / kPoint));
  return cloud;
}

}  // namespace lidar_mapping::ros_border
