// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/ouster_input.hpp"

#include <utility>

#include <std_msgs/String.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Largest number of packets of a turn, by the manual: 2048 columns, 16 in a packet.
constexpr std::size_t kPacketsOfTurn = 128;

}  // namespace

OusterInput::OusterInput(NodeContext& context, InputWatch& watch, int scans, int samples,
                         Takers takers)
    : context_(context),
      watch_(watch),
      scans_(scans),
      samples_(samples),
      takers_(std::move(takers)) {
  const std::string points = context_.node.resolveName("points");
  if (!ouster_name(points, kOusterPoints).empty()) subscribe_beside_points();
}

std::string OusterInput::beside_points(const char* name) const {
  const std::string points = context_.node.resolveName("points");
  return points.substr(0, points.rfind('/')) + name;
}

/// A topic that the user has named is the only one.
bool OusterInput::takes_imu_beside_points() const {
  const std::string imu = context_.node.resolveName("imu");
  return imu == context_.node.resolveName("imu", false) || imu == kUsualImu;
}

void OusterInput::subscribe_beside_points() {
  packets_ = context_.worker.add_channel("lidar_packets",
                                         kPacketsOfTurn * static_cast<std::size_t>(scans_));
  subscribers_.push_back(
      subscribe<std_msgs::String>(context_, beside_points(kOusterMetadata), 1,
                                  [this](const auto& message) { add_metadata(message->data); }));
  if (!takes_imu_beside_points()) return;
  subscribers_.push_back(
      subscribe<WireMessage>(context_, beside_points(kOusterImu), samples_,
                             [this](const auto& message) { add_imu(*message); }));
}

void OusterInput::post(const boost::shared_ptr<const WireMessage>& packet) {
  if (!packets_) subscribe_beside_points();
  context_.worker.post(*packets_, [this, packet] { add_points(*packet); });
}

void OusterInput::add_metadata(const std::string& metadata) {
  for (const RecordedCloud& cloud : feed_.set_metadata(metadata)) takers_.cloud(cloud);
  report();
}

void OusterInput::add_points(const WireMessage& packet) {
  deliver(feed_.add_points(packet.bytes(), from_ros(packet.received)));
  if (!feed_.has_metadata() && losses().without_metadata > 0) warn_without_metadata();
}

void OusterInput::add_imu(const WireMessage& packet) {
  if (has_other_imu_) return;
  if (!is_ouster_packet(packet.type, packet.md5sum)) {
    throw InputError("it holds " + packet.type + ", not " + kOusterPacket);
  }
  takers_.imu(imu_in(packet));
}

sensor_msgs::Imu OusterInput::imu_in(const WireMessage& packet) {
  return feed_.imu_in(packet.bytes(), from_ros(packet.received));
}

void OusterInput::finish() { deliver(feed_.finish()); }

void OusterInput::deliver(const std::optional<RecordedCloud>& cloud) {
  if (cloud) takers_.cloud(*cloud);
  report();
}

void OusterInput::warn_without_metadata() {
  watch_.explain("packets of an Ouster come on " + context_.node.resolveName("points") +
                 ", but no metadata that can be used on " + beside_points(kOusterMetadata) +
                 " (std_msgs/String), without which they are left out: start the sensor's driver "
                 "again, or play a bag that has this topic from its beginning");
}

void OusterInput::report() {
  const OusterLosses& packets = losses();
  if (std::exchange(reported_, packets.total()) == packets.total()) return;
  context_.diagnostics.set("packets before the metadata", packets.without_metadata);
  context_.diagnostics.set("packets late", packets.late);
  context_.diagnostics.set("packets of an unfinished turn", packets.unfinished);
}

}  // namespace lidar_mapping::ros_border
