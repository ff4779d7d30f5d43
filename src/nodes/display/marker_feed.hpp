// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <visualization_msgs/MarkerArray.h>

namespace lidar_mapping::ros_border {

/// Sends changes of markers to the subscribers of a topic: a message has at most `kMarkerBytes`,
/// however long the drive is, so that a correction of a whole long drive is divided into several
/// messages. A new subscriber receives all markers.
class MarkerFeed {
 public:
  using Markers = std::vector<visualization_msgs::Marker>;

  /// Approximate limit for the size of a message of changes, bytes. Chosen: far less than a cloud,
  /// so that it delays nothing.
  static constexpr std::size_t kMarkerBytes = 64 * 1024;

  /// Returns the differences from the sent markers: new or changed ones, and DELETE for removed
  /// ones; the newest marker of each namespace first, then the others in turn. A motion of points
  /// by less than 5 cm is no change. `now` has each pair of namespace and id once.
  visualization_msgs::MarkerArray changes(const Markers& now);
  /// Returns all markers after a DELETEALL, so that subscribers show `now` and nothing else.
  visualization_msgs::MarkerArray whole(const Markers& now);
  /// Whether the last changes() left changes for the next message.
  bool has_more() const { return has_more_; }

 private:
  using Key = std::pair<std::string, int>;
  using Index = std::map<Key, const visualization_msgs::Marker*>;
  struct Outgoing {
    visualization_msgs::MarkerArray message;
    std::size_t bytes = 0;
  };

  void delete_gone(const Index& now, Outgoing& outgoing);
  void send_newest(const Index& now, Outgoing& outgoing);
  void send_in_turn(const Index& now, Outgoing& outgoing);
  bool send(const Key& key, const visualization_msgs::Marker& marker, Outgoing& outgoing);

  std::map<Key, visualization_msgs::Marker> sent_;
  Key last_;  ///< last marker that was sent in turn
  bool has_more_ = false;
};

}  // namespace lidar_mapping::ros_border
