// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <ros/wall_timer.h>

#include "lidar_mapping/map/display_map.hpp"
#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/ros/key_frame_client.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/scratch_folder.hpp"
#include "lidar_mapping/session/session.hpp"

#include "display/drive_display.hpp"
#include "map_viewer_node_config.hpp"
#include "session_frame.hpp"
#include "unclaimed_positions.hpp"

namespace lidar_mapping::ros_border {

/// Subscribed: key_frame, key_frame_poses, loop, loop_verdict, graph_verdict, synced_gnss,
/// gnss_datum, floor, front_end_status, /diagnostics. Published: global_map, odom_path,
/// optimized_path (latched), graph_markers (changes; all of them to a new subscriber). Service:
/// save_map. Missed data are fetched by get_key_frames, so that a restart loses nothing.
class MapViewerNode {
 public:
  using Config = MapViewerNodeConfig;

  MapViewerNode(const Config& config, NodeContext& context);
  ~MapViewerNode();

 private:
  /// The clouds of one run and their map; used by the building thread only.
  struct Run {
    Run(const map::MapConfig& config, const std::filesystem::path& folder)
        : clouds(folder), display(config, clouds) {}
    session::CloudStore clouds;
    map::DisplayMap display;
  };
  /// What a map is made of.
  struct MapInput {
    std::shared_ptr<Run> run;
    std::string run_id;
    KeyFramePoses poses;
    std::optional<GeodeticDatum> datum;
  };

  ros::Publisher advertise_map();
  void subscribe_all();
  void catch_up();
  void begin_run(const std::string& run_id);
  void add_key_frame(const RunKeyFrame& received);
  void update_poses(const KeyFramePosesMessage& message);
  void add_fix(const nav_msgs::Odometry& message);
  void add_loop(const LoopMessage& message);
  void update_candidate(const LoopVerdictMessage& message);
  void update_verdict(const LoopVerdictMessage& message);
  void update_status(const FrontEndStatusMessage& message);
  void update_problem(const diagnostic_msgs::DiagnosticArray& message);
  void refresh_at_intervals();
  void show_map(bool always);
  void build_and_publish(const std::shared_ptr<Run>& run, const KeyFramePoses& poses, bool always);
  void fetch_newest_poses();
  bool save_map(SaveMap::Request& request, SaveMap::Response& response);
  SaveMap::Response save(const MapInput& input, const SaveMap::Request& request);
  void complete(map::ProductOptions& options, const MapInput& input) const;
  std::filesystem::path session_map(const std::string& run_id) const;
  std::optional<session::Session> session_of(const std::string& run_id) const;

  Config config_;
  NodeContext& context_;
  KeyFrameClient back_end_;
  PoseFeed poses_;
  ScratchFolder scratch_{ros::this_node::getName()};
  std::string run_id_;
  std::size_t runs_ = 0;
  std::shared_ptr<Run> run_;
  DriveView view_;
  SessionFrame session_frame_;
  UnclaimedPositions early_fixes_;  ///< from before the run, in the axes of the drive
  Worker::ChannelId requests_;
  Worker builder_;
  Worker::ChannelId builds_, saves_;
  ros::Publisher global_map_;
  bool map_outdated_ = false;  ///< key frames or poses are newer than the displayed map
  ros::WallTimer refresh_timer_;
  DriveDisplay display_;
  KeyFrameSubscription key_frames_;
  std::vector<ros::Subscriber> subscribers_;
  ros::CallbackQueue service_queue_;
  ros::ServiceServer service_;
  ros::AsyncSpinner service_spinner_{1, &service_queue_};
};

}  // namespace lidar_mapping::ros_border
