// SPDX-License-Identifier: BSD-3-Clause
#include "map_viewer_node.hpp"

#include <utility>

#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"

// Received messages, and the display of the graph.
namespace lidar_mapping::ros_border {

MapViewerNode::MapViewerNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      back_end_(context.node),
      poses_([this] { return back_end_.poses(); }),
      session_frame_(context.node),
      requests_(context.worker.add_channel("requests", kPublisherQueue)),
      builder_([](const std::string& what, const std::string& problem) {
        ROS_ERROR_STREAM(what << " failed: " << problem);
      }),
      builds_(builder_.add_channel("building the map", 1)),
      saves_(builder_.add_channel("saving the map", kPublisherQueue)),
      global_map_(advertise_map()),
      display_(context, config.node, [this]() -> const DriveView& { return view_; }),
      key_frames_(context, config.node.queue_size,
                  [this](const RunKeyFrame& received) { add_key_frame(received); }) {
  subscribe_all();
  context.worker.post(requests_, [this] { catch_up(); });
  ros::NodeHandle node(context.node);
  node.setCallbackQueue(&service_queue_);
  service_ = node.advertiseService("save_map", &MapViewerNode::save_map, this);
  service_spinner_.start();
  refresh_at_intervals();
}

MapViewerNode::~MapViewerNode() {
  builder_.stop();  // callers that wait for an answer get an error
  service_spinner_.stop();
}

void MapViewerNode::subscribe_all() {
  const int capacity = config_.node.queue_size;
  subscribers_ = {
      subscribe_numbered<KeyFramePosesMessage>(context_, "key_frame_poses", capacity,
                                               [this](const auto& m) { update_poses(*m); }),
      subscribe<LoopMessage>(context_, "loop", capacity, [this](const auto& m) { add_loop(*m); }),
      subscribe_numbered<LoopVerdictMessage>(context_, "loop_verdict", 10 * capacity,
                                             [this](const auto& m) { update_candidate(*m); }),
      subscribe_numbered<LoopVerdictMessage>(context_, "graph_verdict", kUnlimited,
                                             [this](const auto& m) { update_verdict(*m); }),
      subscribe<nav_msgs::Odometry>(context_, "synced_gnss", capacity,
                                    [this](const auto& m) { add_fix(*m); }),
      subscribe<FloorMessage>(context_, "floor", capacity,
                              [this](const auto& m) {
                                if (view_.floors.add(from_message(*m))) display_.graph_changed();
                              }),
      subscribe<FrontEndStatusMessage>(context_, "front_end_status", capacity,
                                       [this](const auto& m) { update_status(*m); }),
      subscribe<diagnostic_msgs::DiagnosticArray>(context_, "/diagnostics", capacity,
                                                  [this](const auto& m) { update_problem(*m); }),
      subscribe<sensor_msgs::NavSatFix>(context_, "gnss_datum", 1, [this](const auto& m) {
        session_frame_.set_drive_datum({m->latitude, m->longitude, m->altitude});
      })};
}

/// Fetches loops, positions and floors from before this node started; key frames are fetched by
/// KeyFrameSubscription.
void MapViewerNode::catch_up() {
  const auto state = back_end_.run();
  if (!state || (run_ && state->run_id != run_id_)) return;
  for (const GnssPosition& position : state->gnss) view_.add_fix(position.p_enu_antenna);
  for (const Floor& floor : state->floors) view_.floors.add(floor);
  for (const Loop& loop : state->loops) view_.add_loop(loop.from, loop.to);
  display_.graph_changed();
}

/// Data that arrived before the first key frame belong to its run.
void MapViewerNode::begin_run(const std::string& run_id) {
  if (run_) view_ = {};
  view_.track.update(poses_.known(run_id));
  run_id_ = run_id;
  session_frame_.begin_run(run_id);
  for (const GnssPosition& fix : early_fixes_.positions()) {
    view_.add_fix(session_frame_.T_session_drive() * fix.p_enu_antenna);
  }
  early_fixes_ = {};
  run_ = std::make_shared<Run>(config_.stage, scratch_.path() / std::to_string(++runs_));
}

void MapViewerNode::add_key_frame(const RunKeyFrame& received) {
  if (!run_ || received.run_id != run_id_) begin_run(received.run_id);
  const KeyFrame& key_frame = received.key_frame;
  context_.diagnostics.count_input(key_frame.stamp);
  if (key_frame.cloud) run_->clouds.put(key_frame.index, key_frame.cloud);
  view_.track.add(key_frame);
  view_.floors.add_key_frame(key_frame.index, key_frame.stamp);
  context_.diagnostics.set_state(Diagnostics::Level::kOk, "following the drive");
  context_.diagnostics.set("key frames", view_.track.size());
  context_.diagnostics.set("key frames given up", key_frames_.feed().missing());
  display_.graph_changed();
  map_outdated_ = true;
  if (config_.map_cloud_update_interval == 0.0) show_map(false);
}

void MapViewerNode::update_poses(const KeyFramePosesMessage& message) {
  const RunPoses received{message.run_id, from_message(message)};
  key_frames_.note(received.indices());
  const auto changed = poses_.push(received);
  if (!changed || !run_ || changed->run_id != run_id_) return;
  const double moved = view_.track.update(changed->poses);
  if (message.thorough && !message.indices.empty()) view_.optimized = message.indices.back();
  display_.graph_changed();
  map_outdated_ = true;
  const bool at_once = message.thorough || moved > config_.stage.resolution;
  if (at_once || config_.map_cloud_update_interval == 0.0) show_map(false);
}

/// Only the run says in which axes a fix is shown.
void MapViewerNode::add_fix(const nav_msgs::Odometry& message) {
  GnssPosition fix;
  fix.p_enu_antenna = from_message(message.pose.pose).translation;
  if (!run_) return early_fixes_.add(fix);
  if (view_.add_fix(session_frame_.T_session_drive() * fix.p_enu_antenna)) display_.graph_changed();
}

void MapViewerNode::add_loop(const LoopMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  view_.add_loop(message.from, message.to);
  display_.graph_changed();
}

void MapViewerNode::update_candidate(const LoopVerdictMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  const LoopVerdict verdict = from_message(message);
  if (verdict.verdict == Verdict::kAccepted) {
    view_.candidates.erase({message.from, message.to});
  } else {
    view_.candidates[{message.from, message.to}] = verdict;
  }
  display_.graph_changed();
}

void MapViewerNode::update_verdict(const LoopVerdictMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  view_.loops[{message.from, message.to}] = from_message(message);
  display_.graph_changed();
}

void MapViewerNode::update_status(const FrontEndStatusMessage& message) {
  view_.newest_scan = ros::WallTime::now();
  if (std::exchange(view_.state, message.state) != message.state) display_.status_changed();
}

/// Shows in rviz why no scans arrive, as long as that is so.
void MapViewerNode::update_problem(const diagnostic_msgs::DiagnosticArray& message) {
  if (!view_.state.empty()) return;
  for (const auto& status : message.status) {
    if (status.name.find("preprocessing_node") == std::string::npos) continue;
    const bool is_well = status.level == diagnostic_msgs::DiagnosticStatus::OK;
    const std::string problem = is_well ? "" : status.message;
    if (std::exchange(view_.problem, problem) != problem) display_.status_changed();
  }
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::MapViewerNode>(argc, argv);
}
