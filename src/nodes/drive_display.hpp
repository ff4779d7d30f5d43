// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <ros/publisher.h>
#include <ros/wall_timer.h>

#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"

#include "drive_floors.hpp"
#include "graph_markers.hpp"
#include "marker_feed.hpp"

namespace lidar_mapping::ros_border {

/// What is known of a drive, as far as it is shown without clouds.
struct DriveView {
  map::KeyFrameTrack track;
  Verdicts loops;                     ///< with what the graph thinks of them
  Verdicts candidates;                ///< that matching did not accept
  std::vector<Eigen::Vector3d> gnss;  ///< antenna positions in the map, at least a metre apart
  DriveFloors floors;
  std::string state;          ///< of the front end at the newest scan; empty: none has come
  std::string problem;        ///< why no scan has come
  ros::WallTime newest_scan;  ///< when it came

  /// True if it is shown.
  bool add_fix(const Eigen::Vector3d& position);
};

/// Publishes odom_path and optimized_path (at most kPathPoses poses) and graph_markers (what has
/// changed; the whole when somebody subscribes), at most once a second each. What has no subscriber
/// is not made. All but the constructor is called in the worker's thread.
class DriveDisplay {
 public:
  /// `view` gives what is to be shown now.
  DriveDisplay(NodeContext& context, const NodeFields& fields,
               std::function<const DriveView&()> view);

  /// Poses, loops or positions are others now.
  void graph_changed();
  /// The text is another one now.
  void status_changed();

 private:
  template <typename Message>
  ros::Publisher advertise(const std::string& topic, bool latched,
                           void (DriveDisplay::*connected)());
  void show_if_due();
  void show_paths();
  void show_markers();
  void show_all_markers();
  MarkerFeed::Markers markers();
  visualization_msgs::Marker status();

  NodeContext& context_;
  const NodeFields fields_;
  std::function<const DriveView&()> view_;
  Worker::ChannelId tasks_;
  MarkerFeed feed_;
  MarkerFeed::Markers graph_;  ///< of the newest graph that was shown
  bool graph_outdated_ = true;
  bool paths_outdated_ = true;
  bool markers_outdated_ = true;
  bool was_silent_ = false;
  ros::WallTime shown_at_;
  ros::Publisher odom_path_, optimized_path_, graph_markers_;
  ros::WallTimer timer_;
};

}  // namespace lidar_mapping::ros_border
