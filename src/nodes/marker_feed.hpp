// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <visualization_msgs/MarkerArray.h>

namespace lidar_mapping::ros_border {

/// Keeps subscribers of a topic of markers up to date with what has changed: a message has at most
/// `kMarkerBytes`, however long the drive is, so that a correction of a whole long drive goes out
/// over some messages. A late subscriber is given the whole.
class MarkerFeed {
 public:
  using Markers = std::vector<visualization_msgs::Marker>;

  /// About how large a message of changes may be.
  static constexpr std::size_t kMarkerBytes = 64 * 1024;

  /// What differs from what was sent: new or changed markers, and DELETE for those that are gone;
  /// the newest piece of each namespace first, then the others in turn. Points that moved by less
  /// than 5 cm have not changed. `now` has each pair of namespace and id once.
  visualization_msgs::MarkerArray changes(const Markers& now);
  /// All of them, with a DELETEALL before: what subscribers show afterwards is `now` and no more.
  visualization_msgs::MarkerArray whole(const Markers& now);
  /// True if the newest changes() left something for the next.
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
  Key last_;  ///< that was sent, of those that went out in turn
  bool has_more_ = false;
};

}  // namespace lidar_mapping::ros_border
