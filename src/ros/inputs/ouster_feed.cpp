// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/ouster_feed.hpp"

#include <cstdint>
#include <deque>
#include <utility>

#include <ros/serialization.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"

#include "clouds/ouster_metadata.hpp"
#include "clouds/ouster_turns.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Longest time that a packet waits for the metadata, s. Chosen: links to the driver's topics are
/// up before.
constexpr double kLongestWait = 2.0;
/// Largest number of packets that wait. Chosen: as many come in that time with 2048 columns ten
/// times a second and 16 columns in a packet, and they have less than 100 MB.
constexpr std::size_t kMostWaiting = 2560;

/// A packet that waits for the metadata.
struct WaitingPacket {
  std::vector<std::uint8_t> bytes;
  Stamp received = 0;
};

ByteRange packet_in(ByteRange message) try {
  return ouster_packet_in(message);
} catch (const ros::Exception&) {
  throw InputError("a packet of an Ouster is cut off");
}

RecordedCloud recorded(OusterTurn turn) {
  RecordedCloud cloud;
  const auto data = std::make_shared<std::vector<std::uint8_t>>(std::move(turn.cloud.data));
  cloud.message = std::move(turn.cloud);
  cloud.message.data.clear();
  cloud.data = {data->data(), data->size()};
  cloud.memory = data;
  return cloud;
}

std::optional<RecordedCloud> recorded(std::optional<OusterTurn> turn) {
  if (!turn) return std::nullopt;
  return recorded(std::move(*turn));
}

}  // namespace

struct OusterFeed::Impl {
  std::optional<RecordedCloud> add_packet(ByteRange packet, Stamp received);
  void wait(ByteRange packet, Stamp received);
  std::optional<RecordedCloud> end_turns();

  std::string metadata;
  std::optional<OusterTurns> turns;  ///< by the metadata
  std::deque<WaitingPacket> waiting;
  OusterClockTracker clock;
  bool has_points = false;            ///< whose times the clock is known by
  std::size_t late_before = 0;        ///< by the metadata before the present ones
  std::size_t unfinished_before = 0;  ///< by the metadata before the present ones
  OusterLosses losses;
};

OusterFeed::OusterFeed() : impl_(std::make_unique<Impl>()) {}

OusterFeed::~OusterFeed() = default;

/// A driver that is started again publishes its metadata again.
std::vector<RecordedCloud> OusterFeed::set_metadata(const std::string& metadata) {
  if (impl_->turns && metadata == impl_->metadata) return {};
  std::vector<RecordedCloud> clouds;
  try {
    preprocessing::OusterDecoder decoder(ouster_format(metadata));
    if (auto last = impl_->end_turns()) clouds.push_back(std::move(*last));
    impl_->turns.emplace(std::move(decoder));
  } catch (const InputError& error) {
    throw InputError(std::string("the metadata of the Ouster cannot be used: ") + error.what());
  }
  impl_->metadata = metadata;
  for (const WaitingPacket& packet : std::exchange(impl_->waiting, {})) {
    try {
      auto cloud = impl_->add_packet({packet.bytes.data(), packet.bytes.size()}, packet.received);
      if (cloud) clouds.push_back(std::move(*cloud));
    } catch (const InputError&) {
      ++impl_->losses.damaged;
    }
  }
  return clouds;
}

/// Gives the last turn by the present metadata if it has its end; otherwise none of the packets
/// that will come belongs to it.
std::optional<RecordedCloud> OusterFeed::Impl::end_turns() {
  if (!turns) return std::nullopt;
  std::optional<OusterTurn> last = turns->finish(clock.clock());
  unfinished_before += turns->packets_so_far();
  late_before = losses.late;
  losses.unfinished = unfinished_before;
  return recorded(std::move(last));
}

bool OusterFeed::has_metadata() const { return impl_->turns.has_value(); }

std::optional<RecordedCloud> OusterFeed::add_points(ByteRange message, Stamp received) try {
  const ByteRange packet = packet_in(message);
  if (impl_->turns) return impl_->add_packet(packet, received);
  impl_->wait(packet, received);
  return std::nullopt;
} catch (const InputError&) {
  ++impl_->losses.damaged;
  throw;
}

std::optional<RecordedCloud> OusterFeed::Impl::add_packet(ByteRange packet, Stamp received) {
  if (packet.size >= turns->decoder().packet_size()) {
    clock.add(turns->decoder().last_stamp(packet.first), received);
    has_points = true;
  }
  std::optional<OusterTurn> turn = turns->add(packet, received, clock.clock());
  losses.late = late_before + turns->late_packets();
  losses.unfinished = unfinished_before;
  return recorded(std::move(turn));
}

void OusterFeed::Impl::wait(ByteRange packet, Stamp received) {
  const Stamp longest = from_seconds(kLongestWait);
  while (!waiting.empty() &&
         (waiting.size() == kMostWaiting || received - waiting.front().received > longest)) {
    waiting.pop_front();
    ++losses.without_metadata;
  }
  waiting.push_back({{packet.first, packet.first + packet.size}, received});
}

/// The clock is that of the packets with points, as in recordings, where there are any.
sensor_msgs::Imu OusterFeed::imu_in(ByteRange message, Stamp received) {
  ImuSample sample = ouster_imu_in(packet_in(message));
  if (!impl_->has_points) impl_->clock.add(sample.stamp, received);
  sample.stamp = impl_->clock.clock().to_ros(sample.stamp);
  return ouster_imu_message(sample);
}

std::optional<RecordedCloud> OusterFeed::finish() {
  if (!impl_->turns) return std::nullopt;
  std::optional<OusterTurn> turn = impl_->turns->finish(impl_->clock.clock());
  impl_->losses.unfinished = impl_->unfinished_before + impl_->turns->packets_so_far();
  return recorded(std::move(turn));
}

const OusterLosses& OusterFeed::losses() const { return impl_->losses; }

}  // namespace lidar_mapping::ros_border
