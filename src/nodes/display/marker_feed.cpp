// SPDX-License-Identifier: BSD-3-Clause
#include "display/marker_feed.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <ros/serialization.h>

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

/// Smallest motion of a point that is sent, m. Chosen: smaller ones are not visible in the display
/// of a drive.
constexpr double kStep = 0.05;

bool is_elsewhere(const geometry_msgs::Point& a, const geometry_msgs::Point& b) {
  return std::abs(a.x - b.x) > kStep || std::abs(a.y - b.y) > kStep || std::abs(a.z - b.z) > kStep;
}

bool has_changed(const Marker& sent, const Marker& now) {
  if (sent.text != now.text || sent.header.frame_id != now.header.frame_id) return true;
  if (sent.color != now.color || sent.colors != now.colors) return true;
  return !std::equal(sent.points.begin(), sent.points.end(), now.points.begin(), now.points.end(),
                     [](const auto& a, const auto& b) { return !is_elsewhere(a, b); });
}

Marker deletion(const std::string& name, int id) {
  Marker marker;
  marker.ns = name;
  marker.id = id;
  marker.action = Marker::DELETE;
  marker.pose.orientation.w = 1.0;
  return marker;
}

}  // namespace

MarkerArray MarkerFeed::changes(const Markers& now) {
  Index index;
  for (const Marker& marker : now) index[{marker.ns, marker.id}] = &marker;
  Outgoing outgoing;
  has_more_ = false;
  delete_gone(index, outgoing);
  send_newest(index, outgoing);
  send_in_turn(index, outgoing);
  return std::move(outgoing.message);
}

void MarkerFeed::delete_gone(const Index& now, Outgoing& outgoing) {
  for (auto entry = sent_.begin(); entry != sent_.end();) {
    const auto [name, id] = entry->first;
    if (now.count(entry->first) > 0) {
      ++entry;
    } else {
      outgoing.message.markers.push_back(deletion(name, id));
      entry = sent_.erase(entry);
    }
  }
}

/// Sends the newest markers first, because they are at the vehicle.
void MarkerFeed::send_newest(const Index& now, Outgoing& outgoing) {
  for (auto entry = now.begin(); entry != now.end(); ++entry) {
    const auto next = std::next(entry);
    const bool is_newest = next == now.end() || next->first.first != entry->first.first;
    if (is_newest) send(entry->first, *entry->second, outgoing);
  }
}

/// Continues after the end of the last message, so that no marker waits forever.
void MarkerFeed::send_in_turn(const Index& now, Outgoing& outgoing) {
  const auto send_all = [&](auto begin, auto end) {
    for (auto entry = begin; entry != end; ++entry) {
      if (send(entry->first, *entry->second, outgoing)) last_ = entry->first;
    }
  };
  const auto begin = now.upper_bound(last_);
  send_all(begin, now.end());
  send_all(now.begin(), begin);
}

/// False if the marker has not changed, or does not fit into the message.
bool MarkerFeed::send(const Key& key, const Marker& marker, Outgoing& outgoing) {
  const auto known = sent_.find(key);
  if (known != sent_.end() && !has_changed(known->second, marker)) return false;
  const std::size_t size = ros::serialization::serializationLength(marker);
  if (outgoing.bytes > 0 && outgoing.bytes + size > kMarkerBytes) {
    has_more_ = true;
    return false;
  }
  outgoing.bytes += size;
  outgoing.message.markers.push_back(marker);
  sent_[key] = marker;
  return true;
}

MarkerArray MarkerFeed::whole(const Markers& now) {
  MarkerArray message;
  message.markers.push_back(deletion("", 0));
  message.markers.back().action = Marker::DELETEALL;
  sent_.clear();
  has_more_ = false;
  for (const Marker& marker : now) {
    sent_[{marker.ns, marker.id}] = marker;
    message.markers.push_back(marker);
  }
  return message;
}

}  // namespace lidar_mapping::ros_border
