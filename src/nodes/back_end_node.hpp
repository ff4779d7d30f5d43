// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/ros/key_frame_feed.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/own_transform.hpp"
#include "lidar_mapping/ros/transforms.hpp"

#include "back_end/pose_publisher.hpp"
#include "back_end/solver_queue.hpp"
#include "back_end/unstored_key_frames.hpp"
#include "back_end_node_config.hpp"

namespace lidar_mapping::ros_border {

/// Subscribed: key_frame, loop, loop_verdict, synced_gnss, synced_imu, floor, gnss_datum,
/// laser_odom, front_end_status. Published: key_frame_poses (all to a new subscriber, then those
/// that move), optimized_odom, graph_verdict (of all loops to a new subscriber, then of those that
/// change), tf map -> odom.
/// Services: optimize_map, get_key_frames, dump_graph, load_graph. The session's folder stands in
/// the parameter kRunSession beside the node while it runs.
class BackEndNode {
 public:
  using Config = BackEndNodeConfig;

  BackEndNode(const Config& config, NodeContext& context);
  ~BackEndNode();

 private:
  using Run = pipeline::RecordedBackEnd;

  void advertise_verdicts();
  void check_session_directory() const;
  void resume();
  void subscribe_all();
  void advertise_services();
  template <typename Message, typename Handle>
  void listen(const std::string& topic, Handle handle);

  KeyFrameIndex continue_run(const std::string& run_id);
  void receive_key_frame(const KeyFrameMessage& message);
  void add_key_frame(const ReceivedKeyFrame& received);
  void add_early_loops();
  void finalize();
  void report_missing();
  void store_sensor_origin(const ReceivedKeyFrame& received);
  void add_loop(const LoopMessage& message);
  void add_verdict(const LoopVerdictMessage& message);
  void report_dropped(const std::string& what, std::size_t count);
  void add_gnss(const nav_msgs::Odometry& message);
  void publish_in_map(const nav_msgs::Odometry& message);
  void add_or_queue(std::function<void(Run&)> add);

  void begin_run(const std::string& run_id);
  void add_early_measurements();
  void continue_session(session::Session session);
  void set_session(session::Session session, const std::string& run_id);
  std::optional<session::Session> session_of(const std::string& run_id) const;
  void store_configuration();
  void store_datum();

  void optimize_if_due();
  void start_solving(bool thorough);
  void apply_solution(const SolvedProblem& solved);
  void report_failure(const std::string& problem);
  void end_solving(OptimizeMap::Response answer);
  void report_state();
  void publish_poses(const KeyFramePoses& poses, bool thorough);
  void publish_verdicts(const std::vector<LoopVerdict>& verdicts);
  std::vector<std::string> write_files();
  void write_files_for(OptimizeMap::Response& answer);
  void print_session() const;

  bool optimize_map(OptimizeMap::Request& request, OptimizeMap::Response& response);
  std::future<OptimizeMap::Response> request_optimization();
  bool get_key_frames(GetKeyFrames::Request& request, GetKeyFrames::Response& response);
  GetKeyFrames::Response key_frames_without_clouds(const std::vector<KeyFrameIndex>& wanted);
  void add_loop_closing_state(GetKeyFrames::Response& response) const;

  bool dump_graph(DumpGraph::Request& request, DumpGraph::Response& response);
  bool load_graph(LoadGraph::Request& request, LoadGraph::Response& response);
  LoadGraph::Response load(const std::string& path);
  session::Session loaded_session(const std::filesystem::path& path) const;

  Config config_;
  NodeContext& context_;
  SensorFrames sensor_frames_;
  OwnTransform transform_;  ///< map -> odom
  Stamp sent_transform_ = 0;
  PosePublisher poses_;
  ros::Publisher optimized_odom_, verdicts_;
  std::vector<ros::Subscriber> subscribers_;

  // Used by the worker only: the graph, the session, and data that wait for it.
  std::shared_ptr<Run> run_;
  std::string run_id_;
  std::string resumed_run_;  ///< of the session that was opened at the start, if one was
  KeyFrameIndex next_index_ = 0;
  KeyFrameFeed key_frames_;
  std::size_t reported_missing_ = 0;  ///< key frames that were said to be given up
  std::deque<std::function<void(Run&)>> early_;
  std::deque<LoopMessage> early_loops_;
  std::size_t early_dropped_ = 0;  ///< of `early_`, which was full
  std::size_t early_loops_dropped_ = 0;
  std::size_t foreign_verdicts_ = 0;  ///< verdicts of other runs
  std::optional<GeodeticDatum> datum_;
  UnstoredKeyFrames unstored_;
  std::string failure_;  ///< reason; empty if the newest optimisation succeeded
  bool files_outdated_ = false;

  Worker::ChannelId requests_, loops_;
  SolverQueue solver_;
  ros::CallbackQueue service_queue_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner service_spinner_{2, &service_queue_};
};

}  // namespace lidar_mapping::ros_border
