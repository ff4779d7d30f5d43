// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>

#include "bags/wire_array.hpp"
#include "clouds/driver_messages.hpp"
#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

// Bytes, by the formats of geometry_msgs/Point32 and sensor_msgs/ChannelFloat32.
constexpr std::uint32_t kPosition = 3 * 4;
constexpr std::uint32_t kValue = 4;
/// Bytes of an empty channel, by the format: the lengths of its name and of its values.
constexpr std::uint32_t kShortestChannel = 4 + 4;

struct Channel {
  std::string name;
  const std::uint8_t* values;
};

/// Channels that do not have a value for each point are left out.
std::vector<Channel> read_channels(ros::serialization::IStream& stream, std::uint32_t points) {
  std::vector<Channel> channels;
  for (std::uint32_t left = array_length(stream, kShortestChannel); left > 0; --left) {
    Channel channel;
    stream.next(channel.name);
    const std::uint32_t values = array_length(stream, kValue);
    channel.values = stream.advance(values * kValue);
    if (values == points) channels.push_back(channel);
  }
  return channels;
}

std::vector<FieldLayout> fields_of(const std::vector<Channel>& channels) {
  constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;
  std::vector<FieldLayout> fields = {{"x", kFloat, 0}, {"y", kFloat, 4}, {"z", kFloat, 8}};
  std::uint32_t offset = kPosition;
  for (const Channel& channel : channels) {
    fields.push_back({channel.name, kFloat, offset});
    offset += kValue;
  }
  return fields;
}

}  // namespace

RecordedCloud read_point_cloud1(ros::serialization::IStream stream) {
  RecordedCloud cloud;
  stream.next(cloud.message.header);
  const std::uint32_t count = array_length(stream, kPosition);
  const std::uint8_t* const positions = stream.advance(count * kPosition);
  const std::vector<Channel> channels = read_channels(stream, count);
  const auto step = static_cast<std::uint32_t>(kPosition + kValue * channels.size());
  set_layout(cloud.message, fields_of(channels), step, count);
  const auto data = std::make_shared<std::vector<std::uint8_t>>(std::size_t{step} * count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint8_t* to = data->data() + i * step;
    std::memcpy(to, positions + i * kPosition, kPosition);
    to += kPosition;
    for (const Channel& channel : channels) {
      std::memcpy(to, channel.values + i * kValue, kValue);
      to += kValue;
    }
  }
  cloud.data = {data->data(), data->size()};
  cloud.memory = data;
  return cloud;
}

}  // namespace lidar_mapping::ros_border
