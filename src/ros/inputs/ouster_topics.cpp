// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/ouster_topics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <sensor_msgs/Imu.h>
#include <std_msgs/String.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "bags/wire_array.hpp"
#include "clouds/ouster_metadata.hpp"

namespace lidar_mapping::ros_border {

namespace {

namespace traits = ros::message_traits;

const std::string kPoints = "/lidar_packets", kImu = "/imu_packets", kMetadata = "/metadata";
constexpr char kImuFrame[] = "os_imu";  // the driver's default
/// Part of a recording at its ends from which the clock is found, s. Chosen: ten turns.
constexpr double kClockPart = 1.0;
/// Largest offset of clocks that are the same, s. Chosen: packets wait in a network for less.
constexpr double kSameClock = 0.05;
/// How far atomic time, which PTP has, is ahead of UTC, s, by definition of UTC since 2017.
constexpr double kAtomicTime = 37.0;
/// Largest drift of a quartz, s/s. Chosen: ten times that of the data sheets of usual ones.
constexpr double kLargestDrift = 1e-3;

/// What a topic of packets begins with; empty for the topics of another kind.
std::string name_of(const std::string& topic, const std::string& kind) {
  const bool fits = topic.size() > kind.size() &&
                    topic.compare(topic.size() - kind.size(), kind.size(), kind) == 0;
  return fits ? topic.substr(0, topic.size() - kind.size()) : std::string();
}

bool has(const std::vector<BagTopic>& topics, const std::string& name, const std::string& type) {
  return std::any_of(topics.begin(), topics.end(), [&](const BagTopic& topic) {
    return topic.name == name && topic.type == type;
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

/// The bytes of a packet or a text, which are all of its message. Throws ros::Exception if they are
/// cut off.
ByteRange bytes_in(const BagMessage& message) {
  ros::serialization::IStream stream = message.stream();
  return array_bytes(stream);
}

/// Throws InputError for a packet of another size; older drivers add a byte.
ImuSample imu_in(const BagMessage& message) {
  const ByteRange packet = bytes_in(message);
  constexpr std::size_t kSize = preprocessing::kOusterImuPacket;
  if (packet.size != kSize && packet.size != kSize + 1) {
    throw InputError("a packet of an Ouster's IMU has " + std::to_string(packet.size) +
                     " bytes, not " + std::to_string(kSize));
  }
  return preprocessing::ouster_imu(packet.first);
}

sensor_msgs::Imu message_of(ImuSample sample, const OusterClock& clock) {
  sample.stamp = clock.to_ros(sample.stamp);
  return to_message(sample, kImuFrame);
}

/// The first text on the topic.
std::string text_on(const std::vector<std::string>& paths, const std::string& topic) {
  BagStream messages(paths, {topic}, BagStream::Packets::kAsTheyAre);
  while (const auto message = messages.next()) {
    if (!message->is<std_msgs::String>()) continue;
    const ByteRange text = bytes_in(*message);
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
    if (packet->recorded > from + from_seconds(kClockPart)) break;
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
  const auto last = soonest_in(
      paths, topic, std::max(times->first, times->second - from_seconds(kClockPart)), time_of);
  if (!first || !last) return {};
  for (const double offset : {0.0, -kAtomicTime}) {
    const auto is_there = [&](const Soonest& end) {
      return std::abs(to_seconds(end.offset) - offset) < kSameClock;
    };
    if (is_there(*first) && is_there(*last)) return {0, from_seconds(offset), 0.0};
  }
  OusterClock clock{first->sensor, first->offset, 0.0};
  const double passed = to_seconds(last->sensor - first->sensor);
  const double drift = to_seconds(last->offset - first->offset) / passed;
  // A sensor that was switched on anew in between has no clock to follow.
  if (passed > kClockPart && std::abs(drift) < kLargestDrift) clock.drift = drift;
  return clock;
}

}  // namespace

void present_ouster_packets(std::vector<BagTopic>& topics) {
  const std::vector<BagTopic> recorded = topics;
  for (BagTopic& topic : topics) {
    if (topic.type != kOusterPacket) continue;
    const std::string name = name_of(topic.name, kPoints);
    if (!name.empty() && has(recorded, name + kMetadata, "std_msgs/String")) {
      set_type<sensor_msgs::PointCloud2>(topic);
    }
    if (!name_of(topic.name, kImu).empty()) set_type<sensor_msgs::Imu>(topic);
  }
}

OusterTopics::OusterTopics(const std::vector<std::string>& paths,
                           const std::vector<std::string>& packets) {
  for (const std::string& topic : packets) {
    for (const std::string& kind : {kPoints, kImu}) {
      const std::string name = name_of(topic, kind);
      if (name.empty() || sensors_.count(name) > 0) continue;
      try {
        add_sensor(paths, name);
      } catch (const InputError& error) {
        problems_.push_back("the metadata of the Ouster on " + name + kMetadata +
                            " cannot be used: " + error.what());
      } catch (const ros::Exception&) {
        problems_.push_back("the metadata of the Ouster on " + name + kMetadata + " are cut off");
      }
    }
  }
}

void OusterTopics::add_sensor(const std::vector<std::string>& paths, const std::string& name) {
  Sensor& sensor = sensors_[name];
  sensor.points.topic = name + kPoints;
  sensor.imu.topic = name + kImu;
  set_type<sensor_msgs::PointCloud2>(sensor.points);
  set_type<sensor_msgs::Imu>(sensor.imu);
  const std::vector<BagTopic> topics = BagSet(paths).topics();
  const auto is_recorded = [&](const std::string& topic) {
    return std::any_of(topics.begin(), topics.end(),
                       [&](const BagTopic& there) { return there.name == topic; });
  };
  if (is_recorded(name + kPoints) && is_recorded(name + kMetadata)) {
    sensor.turns.emplace(
        preprocessing::OusterDecoder(ouster_format(text_on(paths, name + kMetadata))));
    const preprocessing::OusterDecoder& decoder = sensor.turns->decoder();
    sensor.clock = clock_of(paths, name + kPoints, [&](const BagMessage& message) {
      const ByteRange packet = bytes_in(message);
      if (packet.size < decoder.packet_size()) throw InputError("a packet is cut off");
      return decoder.last_stamp(packet.first);
    });
  } else if (is_recorded(name + kImu)) {
    sensor.clock = clock_of(paths, name + kImu,
                            [](const BagMessage& message) { return imu_in(message).stamp; });
  }
}

std::optional<BagMessage> OusterTopics::add(const BagMessage& message) {
  auto made = made_of(message);
  if (made && made->recorded < from_) made.reset();
  return made;
}

std::optional<BagMessage> OusterTopics::made_of(const BagMessage& message) {
  if (message.getDataType() != kOusterPacket) return message;
  const auto imu = sensors_.find(name_of(message.topic(), kImu));
  if (imu != sensors_.end()) {
    const Sensor& sensor = imu->second;
    return serialized(message_of(imu_in(message), sensor.clock), sensor.imu, message.recorded);
  }
  const auto points = sensors_.find(name_of(message.topic(), kPoints));
  if (points == sensors_.end() || !points->second.turns) return std::nullopt;
  Sensor& sensor = points->second;
  const auto turn = sensor.turns->add(bytes_in(message), message.recorded, sensor.clock);
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

}  // namespace lidar_mapping::ros_border
