// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/ouster_topics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <sensor_msgs/Imu.h>
#include <std_msgs/String.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"

#include "clouds/ouster_metadata.hpp"

namespace lidar_mapping::ros_border {

namespace {

namespace traits = ros::message_traits;

/// Largest drift of a quartz, s/s. Chosen: ten times that of the data sheets of usual ones.
constexpr double kLargestDrift = 1e-3;

/// Whether a topic of that name is recorded, if need be with messages of that type.
bool has(const std::vector<BagTopic>& topics, const std::string& name,
         const std::string& type = "") {
  return std::any_of(topics.begin(), topics.end(), [&](const BagTopic& topic) {
    return topic.name == name && (type.empty() || topic.type == type);
  });
}

template <typename Message, typename Topic>
void set_type(Topic& topic) {
  topic.type = traits::DataType<Message>::value();
  topic.md5sum = traits::MD5Sum<Message>::value();
}

template <typename Message>
BagMessage serialized(const Message& message, const BagConnection& connection, Stamp recorded) {
  const std::uint32_t size = ros::serialization::serializationLength(message);
  const auto bytes = std::make_shared<std::vector<std::uint8_t>>(size);
  ros::serialization::OStream stream(bytes->data(), size);
  ros::serialization::serialize(stream, message);
  return {&connection, recorded, {bytes->data(), bytes->size()}, bytes};
}

/// The first text on the topic.
std::string text_on(const std::vector<std::string>& paths, const std::string& topic) {
  BagStream messages(paths, {topic}, BagStream::Packets::kAsTheyAre);
  while (const auto message = messages.next()) {
    if (!message->is<std_msgs::String>()) continue;
    const ByteRange text = ouster_packet_in(message->data);  // it lies in its message likewise
    return {reinterpret_cast<const char*>(text.first), text.size};
  }
  throw InputError("no message on " + topic + " can be read");
}

// The clock.

/// The time of a packet by the sensor's clock; throws for a damaged one.
using TimeOf = std::function<Stamp(const BagMessage&)>;

/// The packet that came soonest after its time.
struct Soonest {
  Stamp sensor = 0;
  Stamp offset = 0;  ///< of its recording
};

std::optional<Soonest> soonest_in(const std::vector<std::string>& paths, const std::string& topic,
                                  Stamp from, const TimeOf& time_of) {
  BagStream packets(paths, {topic}, BagStream::Packets::kAsTheyAre);
  packets.skip_to(from);
  std::optional<Soonest> soonest;
  for (auto packet = packets.next(); packet; packet = packets.next()) {
    if (packet->recorded > from + from_seconds(kOusterClockPart)) break;
    try {
      const Stamp sensor = OusterClock().to_ros(time_of(*packet));
      const Stamp offset = packet->recorded - sensor;
      if (!soonest || offset < soonest->offset) soonest = {sensor, offset};
    } catch (const InputError&) {
      continue;  // reported when the messages are read
    } catch (const ros::Exception&) {
      continue;
    }
  }
  return soonest;
}

/// The clock is that of the recording, or atomic time, or one of its own, whose offset at both ends
/// gives the drift, so that the times of a turn do not depend on which part of a recording is read.
OusterClock clock_of(const std::vector<std::string>& paths, const std::string& topic,
                     const TimeOf& time_of) {
  const auto times = BagSet(paths).times_of({topic});
  if (!times) return {};
  const auto first = soonest_in(paths, topic, times->first, time_of);
  const auto last =
      soonest_in(paths, topic,
                 std::max(times->first, times->second - from_seconds(kOusterClockPart)), time_of);
  if (!first || !last) return {};
  const auto known = known_offset(first->offset);
  if (known && known == known_offset(last->offset)) return {0, *known, 0.0};
  OusterClock clock{first->sensor, first->offset, 0.0};
  const double passed = to_seconds(last->sensor - first->sensor);
  const double drift = to_seconds(last->offset - first->offset) / passed;
  // A sensor that was switched on anew in between has no clock to follow.
  if (passed > kOusterClockPart && std::abs(drift) < kLargestDrift) clock.drift = drift;
  return clock;
}

}  // namespace

void present_ouster_packets(std::vector<BagTopic>& topics) {
  const std::vector<BagTopic> recorded = topics;
  for (BagTopic& topic : topics) {
    if (topic.type != kOusterPacket) continue;
    const std::string name = ouster_name(topic.name, kOusterPoints);
    if (!name.empty() && has(recorded, name + kOusterMetadata, "std_msgs/String")) {
      set_type<sensor_msgs::PointCloud2>(topic);
    }
    if (!ouster_name(topic.name, kOusterImu).empty()) set_type<sensor_msgs::Imu>(topic);
  }
}

OusterTopics::OusterTopics(const std::vector<std::string>& paths,
                           const std::vector<std::string>& packets) {
  for (const std::string& topic : packets) {
    for (const char* kind : {kOusterPoints, kOusterImu}) {
      const std::string name = ouster_name(topic, kind);
      if (name.empty() || sensors_.count(name) > 0) continue;
      const std::string metadata = "the metadata of the Ouster on " + name + kOusterMetadata;
      try {
        add_sensor(paths, name);
      } catch (const InputError& error) {
        problems_.push_back(metadata + " cannot be used: " + error.what());
      } catch (const ros::Exception&) {
        problems_.push_back(metadata + " are cut off");
      }
    }
  }
}

void OusterTopics::add_sensor(const std::vector<std::string>& paths, const std::string& name) {
  Sensor& sensor = sensors_[name];
  sensor.points.topic = name + kOusterPoints;
  sensor.imu.topic = name + kOusterImu;
  set_type<sensor_msgs::PointCloud2>(sensor.points);
  set_type<sensor_msgs::Imu>(sensor.imu);
  const std::vector<BagTopic> topics = BagSet(paths).topics();
  if (has(topics, sensor.points.topic) && has(topics, name + kOusterMetadata)) {
    sensor.turns.emplace(
        preprocessing::OusterDecoder(ouster_format(text_on(paths, name + kOusterMetadata))));
    const preprocessing::OusterDecoder& decoder = sensor.turns->decoder();
    sensor.clock = clock_of(paths, sensor.points.topic, [&](const BagMessage& message) {
      const ByteRange packet = ouster_packet_in(message.data);
      if (packet.size < decoder.packet_size()) throw InputError("a packet is cut off");
      return decoder.last_stamp(packet.first);
    });
  } else if (has(topics, sensor.imu.topic)) {
    sensor.clock = clock_of(paths, sensor.imu.topic, [](const BagMessage& message) {
      return ouster_imu_in(ouster_packet_in(message.data)).stamp;
    });
  }
}

std::optional<BagMessage> OusterTopics::add(const BagMessage& message) {
  auto made = made_of(message);
  if (made && made->recorded < from_) made.reset();
  return made;
}

std::optional<BagMessage> OusterTopics::made_of(const BagMessage& message) {
  if (message.getDataType() != kOusterPacket) return message;
  const auto imu = sensors_.find(ouster_name(message.topic(), kOusterImu));
  if (imu != sensors_.end()) {
    const Sensor& sensor = imu->second;
    ImuSample sample = ouster_imu_in(ouster_packet_in(message.data));
    sample.stamp = sensor.clock.to_ros(sample.stamp);
    return serialized(ouster_imu_message(sample), sensor.imu, message.recorded);
  }
  const auto points = sensors_.find(ouster_name(message.topic(), kOusterPoints));
  if (points == sensors_.end() || !points->second.turns) return std::nullopt;
  Sensor& sensor = points->second;
  const auto turn =
      sensor.turns->add(ouster_packet_in(message.data), message.recorded, sensor.clock);
  if (!turn) return std::nullopt;
  return serialized(turn->cloud, sensor.points, turn->recorded);
}

std::optional<BagMessage> OusterTopics::finish() {
  for (auto& [name, sensor] : sensors_) {
    if (!sensor.turns) continue;
    const auto turn = sensor.turns->finish(sensor.clock);
    if (turn) return serialized(turn->cloud, sensor.points, turn->recorded);
  }
  return std::nullopt;
}

std::size_t OusterTopics::late_packets() const {
  std::size_t late = 0;
  for (const auto& [name, sensor] : sensors_) {
    if (sensor.turns) late += sensor.turns->late_packets();
  }
  return late;
}

}  // namespace lidar_mapping::ros_border
