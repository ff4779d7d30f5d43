// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/ouster_messages.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/ouster_packets.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "bags/wire_array.hpp"

namespace lidar_mapping::ros_border {

namespace {

constexpr char kImuFrame[] = "os_imu";  // the driver's default

}  // namespace

bool is_ouster_packet(const std::string& type, const std::string& md5sum) {
  return type == kOusterPacket && md5sum == kOusterPacketSum;
}

std::string ouster_name(const std::string& topic, const std::string& kind) {
  const bool fits = topic.size() > kind.size() &&
                    topic.compare(topic.size() - kind.size(), kind.size(), kind) == 0;
  return fits ? topic.substr(0, topic.size() - kind.size()) : std::string();
}

ByteRange ouster_packet_in(ByteRange message) {
  ros::serialization::IStream stream = stream_of(message);
  return array_bytes(stream);
}

ImuSample ouster_imu_in(ByteRange packet) {
  constexpr std::size_t kSize = preprocessing::kOusterImuPacket;
  // Older drivers add a byte.
  if (packet.size != kSize && packet.size != kSize + 1) {
    throw InputError("a packet of an Ouster's IMU has " + std::to_string(packet.size) +
                     " bytes, not " + std::to_string(kSize));
  }
  return preprocessing::ouster_imu(packet.first);
}

sensor_msgs::Imu ouster_imu_message(const ImuSample& sample) {
  return to_message(sample, kImuFrame);
}

}  // namespace lidar_mapping::ros_border
