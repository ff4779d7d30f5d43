// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <ros/publisher.h>
#include <ros/wall_timer.h>

#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"

#include "display/drive_floors.hpp"
#include "display/drive_status.hpp"
#include "display/graph_markers.hpp"
#include "display/marker_feed.hpp"
#include "display/redraw_pace.hpp"

namespace lidar_mapping::ros_border {

/// The state of a drive that is displayed, without clouds.
struct DriveView {
  map::KeyFrameTrack track;
  Verdicts loops;                     ///< with the verdicts of the graph
  Verdicts candidates;                ///< not accepted by matching
  std::vector<Eigen::Vector3d> gnss;  ///< antenna positions in the map, at least a metre apart
  DriveFloors floors;
  std::string state;          ///< of the front end at the newest scan; empty before the first scan
  std::string problem;        ///< why there are no scans
  ros::WallTime newest_scan;  ///< time of its arrival
  std::optional<KeyFrameIndex> optimized;  ///< newest key frame in the last answer of optimize_map

  /// Adds an antenna position unless it is too near to the last one; returns whether it was added.
  bool add_fix(const Eigen::Vector3d& position);
  /// Adds a loop without verdict, unless it is known.
  void add_loop(KeyFrameIndex from, KeyFrameIndex to);
};

/// Publishes odom_path and optimized_path (at most kPathPoses poses) and graph_markers (changes;
/// all of them to a new subscriber), at most once a second each, and only for subscribers. The text
/// on the state follows within a second; paths and graph of a long drive at the pace of RedrawPace.
/// All but the constructor is called in the worker's thread.
class DriveDisplay {
 public:
  /// `view` returns the state to be displayed.
  DriveDisplay(NodeContext& context, const NodeFields& fields,
               std::function<const DriveView&()> view);

  /// Called when poses, loops or positions have changed.
  void graph_changed();
  /// Called when the text has changed.
  void status_changed();

 private:
  void show_if_due();
  void draw_graph();
  void show_paths();
  void show_graph();
  void show_status();
  void show_all_markers();
  visualization_msgs::Marker status_marker();

  NodeContext& context_;
  const NodeFields fields_;
  std::function<const DriveView&()> view_;
  Worker::ChannelId tasks_;
  MarkerFeed graph_feed_, status_feed_;  ///< Both are sent on graph_markers.
  MarkerFeed::Markers graph_;            ///< As it was drawn last.
  DriveStatus status_;                   ///< Its figures are those of graph_.
  bool graph_outdated_ = true;
  bool status_outdated_ = true;
  bool was_silent_ = false;
  RedrawPace graph_pace_;
  ros::WallTime status_shown_at_;
  ros::Publisher odom_path_, optimized_path_, graph_markers_;
  ros::WallTimer timer_;
};

}  // namespace lidar_mapping::ros_border
