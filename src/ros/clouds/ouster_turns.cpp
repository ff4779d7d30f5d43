// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ouster_turns.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "clouds/point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::OusterPoint;
using Points = std::vector<OusterPoint>;

constexpr char kFrame[] = "os_lidar";  // the driver's default
/// Bytes of a point in the cloud: four floats and the time, by the layout of cloud_of().
constexpr std::uint32_t kPoint = 5 * sizeof(float);
/// Longest turn, s. Chosen: twice that of the slowest mode, 5 Hz; a time farther off is damaged.
constexpr double kLongestTurn = 0.4;

/// Stamps of whose median a turn's time is known. Chosen: no packet has half of them.
constexpr std::size_t kStamps = 1000;

/// The median of the stamps of points that are spread over the turn: any one may be damaged.
Stamp usual_stamp(const Points& points) {
  std::vector<Stamp> stamps;
  const std::size_t step = points.size() / kStamps + 1;
  for (std::size_t i = 0; i < points.size(); i += step) stamps.push_back(points[i].stamp);
  return median(std::move(stamps));
}

/// Without the points whose time is not that of the others.
void drop_damaged_times(Points& points) {
  const Stamp stamp = usual_stamp(points);
  const Stamp farthest = from_seconds(kLongestTurn);
  const auto is_off = [&](const OusterPoint& point) {
    return point.stamp < stamp - farthest || point.stamp > stamp + farthest;
  };
  points.erase(std::remove_if(points.begin(), points.end(), is_off), points.end());
}

sensor_msgs::PointCloud2 cloud_of(const Points& points, Stamp begin) {
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  set_layout(cloud,
             {{"x", PointField::FLOAT32, 0},
              {"y", PointField::FLOAT32, 4},
              {"z", PointField::FLOAT32, 8},
              {"reflectivity", PointField::FLOAT32, 12},
              {"t", PointField::UINT32, 16}},
             kPoint, static_cast<std::uint32_t>(points.size()));
  cloud.data.resize(points.size() * kPoint);
  std::uint8_t* at = cloud.data.data();
  for (const OusterPoint& point : points) {
    const auto time = static_cast<std::uint32_t>(point.stamp - begin);
    std::memcpy(at, &point.point, sizeof point.point);
    std::memcpy(at + sizeof point.point, &time, sizeof time);
    at += kPoint;
  }
  return cloud;
}

bool begins_earlier(const OusterPoint& a, const OusterPoint& b) { return a.stamp < b.stamp; }

}  // namespace

OusterTurns::OusterTurns(preprocessing::OusterDecoder decoder) : decoder_(std::move(decoder)) {}

std::optional<OusterTurn> OusterTurns::add(ByteRange packet, Stamp recorded,
                                           const OusterClock& clock) {
  const std::size_t size = decoder_.packet_size();
  // Older drivers add a byte.
  if (packet.size != size && packet.size != size + 1) {
    throw InputError("a packet of an Ouster has " + std::to_string(packet.size) + " bytes, not " +
                     std::to_string(size) + " as its metadata say");
  }
  std::optional<OusterTurn> turn;
  const std::uint16_t frame = decoder_.frame(packet.first);
  if (is_late(frame)) {
    ++late_packets_;
    return std::nullopt;
  }
  if (frame_ != frame) {
    if (frame_) turn = take(clock);
    frame_ = frame;
    is_given_ = false;
  }
  ++packets_;
  recorded_ = recorded;
  has_begin_ |= decoder_.has_column(packet.first, decoder_.format().first_column);
  has_end_ |= decoder_.has_column(packet.first, decoder_.format().last_column);
  decoder_.decode(packet.first, points_);
  return turn;
}

/// The network may deliver the last packets of a turn behind the first ones of the next.
bool OusterTurns::is_late(std::uint16_t frame) const {
  if (!frame_) return false;
  return frame == static_cast<std::uint16_t>(*frame_ - 1) || (is_given_ && frame == *frame_);
}

std::optional<OusterTurn> OusterTurns::finish(const OusterClock& clock) {
  if (is_given_ || !has_end_) return std::nullopt;
  is_given_ = true;
  return take(clock);
}

std::optional<OusterTurn> OusterTurns::take(const OusterClock& clock) {
  Points points = std::exchange(points_, {});
  points_.reserve(points.size());
  const bool is_cut = std::exchange(is_first_, false) && !has_begin_;
  has_begin_ = has_end_ = false;
  packets_ = 0;
  if (is_cut || points.empty()) return std::nullopt;
  drop_damaged_times(points);
  const Stamp begin = std::min_element(points.begin(), points.end(), begins_earlier)->stamp;
  OusterTurn turn;
  turn.recorded = recorded_;
  turn.cloud = cloud_of(points, begin);
  turn.cloud.header.seq = *frame_;
  turn.cloud.header.stamp = to_ros(clock.to_ros(begin));
  turn.cloud.header.frame_id = kFrame;
  return turn;
}

}  // namespace lidar_mapping::ros_border
