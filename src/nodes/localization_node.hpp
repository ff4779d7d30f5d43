// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <ros/wall_timer.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/localization/localizer.hpp"
#include "lidar_mapping/pipeline/drive_recorder.hpp"
#include "lidar_mapping/pipeline/pose_claim.hpp"
#include "lidar_mapping/pipeline/scan_pairing.hpp"
#include "lidar_mapping/pipeline/session_map.hpp"
#include "lidar_mapping/ros/key_frame_feed.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/own_transform.hpp"
#include "lidar_mapping/ros/scratch_folder.hpp"
#include "lidar_mapping/ros/transforms.hpp"

#include "localization_node_config.hpp"

namespace lidar_mapping::ros_border {

/// Subscribed: current_scan, laser_odom and lidar_origin of the front end, initialpose; with
/// record_session its key_frame and front_end_status, too. Published: ~pose, localized_odom,
/// localized_path, localization_status, localized_scan (while somebody subscribes),
/// localization_map (latched), tf map -> odom. Services: relocalize, load_map, save_session. Says
/// so when no scans come, by the wall clock. Maps are read, and sessions written, in a thread of
/// their own; scans go on meanwhile.
class LocalizationNode {
 public:
  using Config = LocalizationNodeConfig;

  LocalizationNode(const Config& config, NodeContext& context);
  ~LocalizationNode();

 private:
  /// A map, the localisation in it, and the drive there.
  struct ActiveMap {
    ActiveMap(const std::string& folder, const loop_closing::LoopClosingConfig& verification)
        : map(folder, verification, 1), localizer(map.index()) {}
    pipeline::SessionMap map;
    localization::Localizer localizer;
    std::optional<pipeline::DriveRecorder> recorder;
    std::string why_not_recorded;  ///< if there is no recorder
  };
  /// What save_session takes from the worker.
  struct DriveSoFar {
    std::shared_ptr<const pipeline::MapExtender> extender;
    pipeline::LocalizedDrive drive;
  };

  void advertise_topics();
  void subscribe_all();
  void subscribe_drive();
  void advertise_services();

  void add_odometry(const nav_msgs::Odometry& message);
  void add_scan(const sensor_msgs::PointCloud2& message);
  void set_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void process_ready();
  void watch_scans();
  void process(pipeline::PairedScan&& paired);
  std::optional<Eigen::Vector3d> lidar_origin();
  void publish_pose(const localization::LocalizationResult& result,
                    const pipeline::PairedScan& paired);
  void publish_scan(const localization::LocalizationResult& result);
  void extend_path(const localization::LocalizationResult& result);
  void publish_status(const localization::LocalizationResult& result, double seconds);
  void report(const localization::LocalizationResult& result, double seconds);

  void load_first(const std::string& folder);
  std::string load(const std::string& folder);
  void use(std::shared_ptr<ActiveMap> active_map, const PointCloud& cloud);
  bool relocalize(Relocalize::Request& request, Relocalize::Response& response);
  bool load_map(LoadMap::Request& request, LoadMap::Response& response);

  void begin_recording(ActiveMap& active_map);
  pipeline::DriveRecorder* present_recorder();
  void record(const RunKeyFrame& received);
  void record(const localization::LocalizationResult& place);
  void withdraw_place();
  bool save_session(SaveSession::Request& request, SaveSession::Response& response);
  DriveSoFar drive_so_far();
  static SaveSession::Response saved(const DriveSoFar& recorded,
                                     const std::filesystem::path& folder);

  Config config_;
  NodeContext& context_;
  pipeline::ScanPairing pairing_;
  std::optional<ScratchFolder> scratch_;  ///< with record_session
  std::size_t recordings_ = 0;            ///< that the loader began
  KeyFrameFeed key_frames_;
  SensorFrames sensor_frames_;
  OwnTransform transform_;                       ///< map -> odom
  std::shared_ptr<ActiveMap> active_map_;        ///< none until a map is read
  std::optional<Eigen::Vector3d> p_base_lidar_;  ///< that the front end told
  pipeline::PoseClaim initial_pose_;             ///< that the next scan in a map is told
  std::string loading_ = "no map yet";           ///< why no map is active
  std::optional<Stamp> last_odometry_;           ///< newest one
  ros::WallTime last_scan_;  ///< when the newest one was processed; zero: none, or that was said
  std::string state_;        ///< that was logged last
  KeyFramePoses path_;
  KeyFrameIndex next_path_index_ = 0;
  ros::Publisher pose_, odometry_, path_topic_, status_, map_cloud_, scan_;
  std::vector<ros::Subscriber> subscribers_;
  Worker::ChannelId requests_;
  Worker loader_;
  Worker::ChannelId loads_;
  ros::CallbackQueue service_queue_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner service_spinner_{3, &service_queue_};  // one for each service: they wait
  ros::WallTimer scan_watch_;
};

}  // namespace lidar_mapping::ros_border
