// SPDX-License-Identifier: BSD-3-Clause
#include "localization_node.hpp"

#include <utility>

#include <geometry_msgs/PointStamped.h>
#include <nav_msgs/Path.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/thread_time.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "display/path_display.hpp"
#include "localization/matched_cloud.hpp"
#include "worker_tasks.hpp"

// Received scans, and what is published about them.
namespace lidar_mapping::ros_border {

namespace {

using localization::LocalizationResult;
using localization::LocalizationState;

/// m between the poses of the path on display. Chosen: bends stay round.
constexpr double kPathSpacing = 1.0;
/// Poses of the path that are kept, so that memory is bounded. Chosen: the last two kilometres.
constexpr std::size_t kLongestPath = 2000;

/// s without a scan after which that is said, and between looks at it. Chosen: 15 periods of a
/// LiDAR at 10 Hz, and said within 2 s.
constexpr double kSilence = 1.5;
constexpr double kWatchPeriod = 0.25;

std::optional<Pose> initial_pose_of(const LocalizationNodeConfig& config) {
  if (!config.use_initial_pose) return std::nullopt;
  return pose_from_degrees(config.initial_pose);
}

/// The front end states no covariance of the motion to its first scan, because none led there.
std::optional<Covariance6> step_covariance(const nav_msgs::Odometry& message, double seconds) {
  const Covariance6 covariance = from_array(message.twist.covariance);
  if (!covariance.allFinite() || covariance.isZero()) return std::nullopt;
  return Covariance6(covariance * seconds * seconds);
}

Diagnostics::Level level_of(LocalizationState state) {
  return state == LocalizationState::kFollowing ? Diagnostics::Level::kOk
                                                : Diagnostics::Level::kWarning;
}

}  // namespace

LocalizationNode::LocalizationNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      key_frames_(
          [](const auto&) { return std::vector<ReceivedKeyFrame>(); },  // there is no back end
          [this](const RunKeyFrame& received) { record(received); }),
      transform_(context, config.node.map_frame, config.node.odom_frame),
      requests_(context.worker.add_channel("requests", kPublisherQueue)),
      loader_([](const std::string& what, const std::string& problem) {
        ROS_ERROR_STREAM(what << " failed: " << problem);
      }),
      loads_(loader_.add_channel("reading the map", kPublisherQueue)) {
  if (const auto T_map_base = initial_pose_of(config)) initial_pose_.set(*T_map_base);
  advertise_topics();
  if (config.record_session) scratch_.emplace(ros::this_node::getName());
  if (!config.map.empty()) {
    session::find_session(expanded_path(config.map));  // it has to exist
    loading_ = "reading the map " + config.map;
    loader_.post(loads_, [this, folder = config.map] { load_first(folder); });
  }
  subscribe_all();
  advertise_services();
  scan_watch_ = do_at_intervals(context, "scan watch", kWatchPeriod, [this] { watch_scans(); });
}

LocalizationNode::~LocalizationNode() {
  scan_watch_.stop();
  loader_.stop();  // callers that wait for an answer get an error
  service_spinner_.stop();
}

void LocalizationNode::advertise_topics() {
  pose_ = context_.private_node.advertise<geometry_msgs::PoseWithCovarianceStamped>(
      "pose", kPublisherQueue);
  odometry_ = context_.node.advertise<nav_msgs::Odometry>("localized_odom", kPublisherQueue);
  path_topic_ = context_.node.advertise<nav_msgs::Path>("localized_path", 1, true);
  status_ =
      context_.node.advertise<LocalizationStatusMessage>("localization_status", kPublisherQueue);
  map_cloud_ = context_.node.advertise<sensor_msgs::PointCloud2>("localization_map", 1, true);
  scan_ = context_.node.advertise<sensor_msgs::PointCloud2>("localized_scan", 1);
}

void LocalizationNode::subscribe_all() {
  const int capacity = config_.node.queue_size;
  subscribers_ = {
      subscribe_numbered<nav_msgs::Odometry>(context_, "laser_odom", capacity,
                                             [this](const auto& m) { add_odometry(*m); }),
      subscribe_numbered<sensor_msgs::PointCloud2>(context_, "current_scan", capacity,
                                                   [this](const auto& m) { add_scan(*m); }),
      subscribe<geometry_msgs::PointStamped>(context_, "lidar_origin", 1,
                                             [this](const auto& m) {
                                               const Eigen::Vector3d p(m->point.x, m->point.y,
                                                                       m->point.z);
                                               if (p.allFinite()) p_base_lidar_ = p;
                                             }),
      subscribe<geometry_msgs::PoseWithCovarianceStamped>(
          context_, "initialpose", capacity, [this](const auto& m) { set_initial_pose(*m); })};
  if (config_.record_session) subscribe_drive();
}

void LocalizationNode::add_odometry(const nav_msgs::Odometry& message) {
  if (frame_name(message.child_frame_id) != config_.node.base_frame) {
    throw InputError("laser_odom is of '" + message.child_frame_id + "', not of '" +
                     config_.node.base_frame + "'");
  }
  const Stamp stamp = from_ros(message.header.stamp);
  const double seconds = last_odometry_ ? to_seconds(stamp - *last_odometry_) : 0.0;
  last_odometry_ = stamp;
  const Pose T_odom_base = from_message(message.pose.pose);
  if (pipeline::DriveRecorder* const recorder = present_recorder()) {
    recorder->add_odometry(stamp, T_odom_base);
  }
  pairing_.add({stamp,
                T_odom_base,
                step_covariance(message, seconds),
                {from_message(message.twist.twist), from_array(message.twist.covariance)}});
  process_ready();
}

void LocalizationNode::add_scan(const sensor_msgs::PointCloud2& message) {
  if (frame_name(message.header.frame_id) != config_.node.base_frame) {
    throw InputError("current_scan is in '" + message.header.frame_id + "', not in '" +
                     config_.node.base_frame + "'");
  }
  Scan scan{from_ros(message.header.stamp), from_message(message)};
  context_.diagnostics.count_input(scan.stamp);
  pairing_.add(std::move(scan));
  process_ready();
}

/// From rviz ("2D Pose Estimate") or another program.
void LocalizationNode::set_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (frame_name(message.header.frame_id) != config_.node.map_frame) {
    throw InputError("the initial pose is in frame '" + message.header.frame_id +
                     "'; give it in '" + config_.node.map_frame + "'");
  }
  const Pose T_map_base = from_message(message.pose.pose);
  initial_pose_.set(T_map_base);
  ROS_INFO_STREAM("searching near " << T_map_base.translation.transpose() << " m, heading "
                                    << yaw_of(T_map_base.rotation) << " rad");
}

void LocalizationNode::process_ready() {
  for (pipeline::PairedScan& paired : pairing_.take_ready()) process(std::move(paired));
}

void LocalizationNode::process(pipeline::PairedScan&& paired) {
  if (!initial_pose_.carry_to(paired.input)) {
    ROS_WARN(
        "the initial pose is left out: odometry was interrupted before a map was read; give it "
        "again");
  }
  if (!active_map_) {
    context_.diagnostics.set_state(Diagnostics::Level::kWarning, loading_);
    return;
  }
  if (const auto T_map_base = initial_pose_.take()) {
    withdraw_place();
    active_map_->localizer.set_initial_pose(*T_map_base);
  }
  const ThreadTime time;
  paired.input.p_base_lidar = lidar_origin().value_or(Eigen::Vector3d::Zero());
  const LocalizationResult result = active_map_->localizer.process(paired.input);
  const double seconds = time.seconds();
  last_scan_ = ros::WallTime::now();
  if (localization::has_pose(result.state)) {
    publish_pose(result, paired);
    publish_scan(result);
  }
  publish_status(result, seconds);
  report(result, seconds);
  record(result);
}

std::optional<Eigen::Vector3d> LocalizationNode::lidar_origin() {
  const auto configured = sensor_frames_.origin_of(config_.lidar_frame, config_.node.base_frame);
  return configured ? configured : p_base_lidar_;
}

/// Who waits for the next pose has to know that none will come. The place itself is kept: how
/// odometry goes on decides about it.
void LocalizationNode::watch_scans() {
  if (last_scan_.isZero() || (ros::WallTime::now() - last_scan_).toSec() < kSilence) return;
  last_scan_ = {};
  LocalizationResult silent;
  silent.stamp = last_odometry_.value_or(0);
  silent.state = LocalizationState::kLost;
  silent.reason = formatted("no scan for %.1f s", kSilence);
  publish_status(silent, 0.0);
  report(silent, 0.0);
}

void LocalizationNode::publish_pose(const LocalizationResult& result,
                                    const pipeline::PairedScan& paired) {
  const NodeFields& frames = config_.node;
  transform_.send(result.T_map_base * paired.T_odom_base.inverse(), result.stamp);
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header = header_of(result.stamp, frames.map_frame);
  pose.pose.pose = to_message(result.T_map_base);
  pose.pose.covariance = to_array(in_parent_axes(result.covariance, result.T_map_base));
  pose_.publish(pose);
  nav_msgs::Odometry odometry;
  odometry.header = pose.header;
  odometry.child_frame_id = frames.base_frame;
  odometry.pose = pose.pose;
  odometry.twist.twist = to_twist(paired.twist.value);
  odometry.twist.covariance = to_array(paired.twist.covariance);
  odometry_.publish(odometry);
  extend_path(result);
}

/// In the map, so that rviz shows it there without waiting for tf.
void LocalizationNode::publish_scan(const LocalizationResult& result) {
  if (scan_.getNumSubscribers() == 0) return;
  scan_.publish(matched_cloud(active_map_->localizer.matched_points(), result.T_map_base,
                              result.stamp, config_.node.map_frame));
}

void LocalizationNode::extend_path(const LocalizationResult& result) {
  auto& poses = path_.poses;
  const Eigen::Vector3d& position = result.T_map_base.translation;
  if (!poses.empty() && (poses.back().T_map_base.translation - position).norm() < kPathSpacing) {
    return;
  }
  poses.push_back({next_path_index_++, result.stamp, result.T_map_base});
  if (poses.size() > kLongestPath) poses.erase(poses.begin());
  path_topic_.publish(to_path(path_, config_.node.map_frame));
}

void LocalizationNode::publish_status(const LocalizationResult& result, double seconds) {
  LocalizationStatusMessage message;
  message.header = header_of(result.stamp, config_.node.map_frame);
  message.state = localization::to_string(result.state);
  message.reason = result.reason;
  message.probability = result.probability;
  message.agreement = result.agreement;
  message.coverage = result.coverage;
  message.hypotheses = static_cast<std::uint32_t>(result.hypotheses);
  message.seconds = seconds;
  status_.publish(message);
}

/// Changes of the state are logged, scans are not.
void LocalizationNode::report(const LocalizationResult& result, double seconds) {
  const std::string state = localization::to_string(result.state);
  context_.diagnostics.count_output(result.stamp);
  context_.diagnostics.set_state(level_of(result.state), state + ": " + result.reason);
  context_.diagnostics.set("probability", result.probability);
  context_.diagnostics.set("agreement", result.agreement);
  context_.diagnostics.set("coverage", result.coverage);
  context_.diagnostics.set("seconds per scan", seconds);
  context_.diagnostics.set("scans without odometry", pairing_.given_up());
  if (state == std::exchange(state_, state)) return;
  if (!localization::has_pose(result.state)) path_.poses.clear();
  if (result.state == LocalizationState::kLost) {
    ROS_WARN_STREAM(state << ": " << result.reason);
  } else {
    ROS_INFO_STREAM(state << ": " << result.reason);
  }
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::LocalizationNode>(argc,
                                                                                          argv);
}
