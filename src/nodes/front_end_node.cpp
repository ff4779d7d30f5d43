// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <std_msgs/UInt32.h>

#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/front_end/corrected_cloud.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/front_end/status_warnings.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/key_frame_client.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/own_transform.hpp"
#include "lidar_mapping/ros/repeating_publisher.hpp"
#include "lidar_mapping/ros/scan_assembler.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/transforms.hpp"

#include "worker_tasks.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Idle time after which a scan is processed without the sensors that it waits for.
constexpr std::chrono::milliseconds kIdle{500};
/// Scans that are late or repeated are older than the newest one by less than this time.
constexpr Stamp kReplayTolerance = from_seconds(0.5);
/// Number of key frames that are sent again to a new subscriber. Chosen: more than a vehicle makes
/// in the seconds in which a node starts.
constexpr std::uint32_t kRepeatedKeyFrames = 30;

}  // namespace

/// Subscribed: synced_cloud, synced_imu, synced_velocity, synced_gnss (first pose only),
/// scans_lost, initialpose (before the first scan), external_odom (with `odometry: external`).
/// Published: laser_odom, key_frame, front_end_status, current_scan, local_map, lidar_origin
/// (latched), tf odom -> base_link. Asks get_key_frames once, at the first scan.
class FrontEndNode {
 public:
  using Config = LidarNodeConfig<front_end::FrontEndConfig>;

  FrontEndNode(const Config& config, NodeContext& context);

 private:
  void subscribe_sensors();
  void add_cloud(const sensor_msgs::PointCloud2& message);
  bool move_to_lidar(PointCloud& cloud);
  void set_lidar_origin(Stamp stamp);
  bool is_replayed(Stamp stamp);
  void add_gnss(const nav_msgs::Odometry& message);
  void set_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void process(std::vector<AssembledScan> scans);
  void process(const AssembledScan& assembled);
  void begin_run();
  void finalize();
  void publish_final(const front_end::FrontEndResult& result);
  void publish_odometry(const front_end::FrontEndResult& result);
  void publish_clouds(const front_end::FrontEndResult& result, const AssembledScan& assembled);
  void publish_local_map(Stamp stamp);
  void report(const front_end::FrontEndResult& result);
  void show_figures(const front_end::FrontEndStatus& status);
  void warn_of_repetition();
  void warn_of_match(const front_end::FrontEndStatus& status);

  Config config_;
  NodeContext& context_;
  KeyFrameClient back_end_;
  front_end::FrontEnd front_end_;
  ScanAssembler assembler_;
  SensorFrames sensor_frames_;
  Pose T_base_scan_;                             ///< of the scans' frame
  std::optional<Eigen::Vector3d> p_base_lidar_;  ///< as key frames tell it
  OwnTransform transform_;                       ///< odom -> base_link
  WarningLimiter limiter_;
  std::string run_id_;
  std::optional<front_end::FrontEndResult> previous_;
  std::optional<Stamp> end_of_resumed_;  ///< stamp of the last key frame of the run that goes on
  std::size_t scans_replayed_ = 0;
  std::uint32_t scans_lost_upstream_ = 0;  ///< scans that were lost before or in preprocessing
  ros::Publisher laser_odom_, status_, current_scan_, local_map_, lidar_origin_;
  RepeatingPublisher<KeyFrameMessage> key_frame_;
  std::vector<ros::Subscriber> subscribers_;
};

FrontEndNode::FrontEndNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      back_end_(context.node),
      front_end_(config.stage),
      assembler_(config.stage.odometry == front_end::OdometrySource::kExternal),
      transform_(context, config.node.odom_frame, config.node.base_frame),
      key_frame_(context.node, "key_frame", kRepeatedKeyFrames) {
  const std::string notice = registration::describe_substitution(config.stage.registration);
  if (!notice.empty()) ROS_INFO_STREAM(notice);
  laser_odom_ = context.node.advertise<nav_msgs::Odometry>("laser_odom", kPublisherQueue);
  status_ = context.node.advertise<FrontEndStatusMessage>("front_end_status", kPublisherQueue);
  current_scan_ = context.node.advertise<sensor_msgs::PointCloud2>("current_scan", 1);
  lidar_origin_ = context.node.advertise<geometry_msgs::PointStamped>("lidar_origin", 1, true);
  // Made while somebody subscribes; who subscribes after the last key frame gets it at once.
  const auto channel = context.worker.add_channel("subscribers", kPublisherQueue);
  local_map_ = advertise<sensor_msgs::PointCloud2>(context, "local_map", 1, channel, [this] {
    if (previous_) publish_local_map(previous_->stamp);
  });
  subscribe_sensors();
  context.worker.set_idle_task(kIdle, [this] {
    process(assembler_.flush());
    finalize();
  });
}

void FrontEndNode::subscribe_sensors() {
  const int capacity = config_.node.queue_size;
  const auto then_process = [this](auto&& add) {
    return [this, add](const auto& message) {
      add(*message);
      process(assembler_.take_ready());
    };
  };
  subscribers_ = {
      subscribe_numbered<sensor_msgs::PointCloud2>(
          context_, "synced_cloud", capacity,
          then_process([this](const auto& m) { add_cloud(m); })),
      subscribe<SyncedInputsMessage>(
          context_, "synced_inputs", capacity, then_process([this](const auto& m) {
            assembler_.add_inputs(from_ros(m.header.stamp),
                                  {m.imu != 0, m.velocity != 0, m.gnss != 0, uneven_turning_of(m),
                                   felt_force_of(m), fingerprint_of(m)});
          })),
      subscribe<sensor_msgs::Imu>(
          context_, "synced_imu", capacity,
          then_process([this](const auto& m) { assembler_.add_imu(from_message(m)); })),
      subscribe<geometry_msgs::TwistStamped>(
          context_, "synced_velocity", capacity,
          then_process([this](const auto& m) { assembler_.add_velocity(from_message(m)); })),
      subscribe<nav_msgs::Odometry>(context_, "synced_gnss", capacity,
                                    then_process([this](const auto& m) { add_gnss(m); })),
      subscribe<std_msgs::UInt32>(context_, "scans_lost", 1,
                                  [this](const auto& m) { scans_lost_upstream_ = m->data; })};
  subscribers_.push_back(subscribe<geometry_msgs::PoseWithCovarianceStamped>(
      context_, "initialpose", capacity, [this](const auto& m) { set_initial_pose(*m); }));
  if (config_.stage.odometry != front_end::OdometrySource::kExternal) return;
  subscribers_.push_back(subscribe<nav_msgs::Odometry>(
      context_, "external_odom", 10 * capacity, then_process([this](const auto& m) {
        assembler_.add_odometry(from_ros(m.header.stamp), from_message(m.pose.pose));
      })));
}

void FrontEndNode::add_cloud(const sensor_msgs::PointCloud2& message) {
  Scan scan{from_ros(message.header.stamp), from_message(message)};
  context_.diagnostics.count_input(scan.stamp);
  if (is_replayed(scan.stamp)) return;
  if (scan.cloud.empty()) throw InputError("the scan has no point with finite coordinates");
  T_base_scan_ = sensor_frames_.required(config_.node.base_frame, message.header.frame_id);
  const bool is_moved = frame_name(message.header.frame_id) == config_.node.base_frame;
  if (!is_moved) front_end_.set_sensor_pose(T_base_scan_);
  if (!is_moved || move_to_lidar(scan.cloud)) set_lidar_origin(scan.stamp);
  assembler_.add_scan(std::move(scan));
}

/// Preprocessing publishes scans in the LiDAR's frame; another program may have transformed them to
/// base_link. Returns whether it is known where the LiDAR is.
bool FrontEndNode::move_to_lidar(PointCloud& cloud) {
  if (config_.lidar_frame.empty()) {
    ROS_INFO_STREAM_ONCE("the scans are in the frame of the vehicle, '"
                         << config_.node.base_frame
                         << "': the LiDAR is taken to be at its origin; if they were moved there, "
                            "name the frame of the LiDAR by lidar_frame");
    return true;
  }
  const auto T_base_lidar = sensor_frames_.lookup(config_.node.base_frame, config_.lidar_frame);
  if (!T_base_lidar) return false;
  T_base_scan_ = *T_base_lidar;
  cloud = transformed(cloud, T_base_scan_.inverse());
  front_end_.set_sensor_pose(T_base_scan_);
  return true;
}

/// Key frames and localisation get clouds in base_link, which do not say whence they were measured.
void FrontEndNode::set_lidar_origin(Stamp stamp) {
  if (p_base_lidar_ == T_base_scan_.translation) return;
  p_base_lidar_ = T_base_scan_.translation;
  geometry_msgs::PointStamped message;
  message.header = header_of(stamp, config_.node.base_frame);
  message.point = to_message(T_base_scan_).position;
  lidar_origin_.publish(message);
}

/// A large jump back in time means that the recording was restarted; a drive that does not come
/// behind the session that it goes on with would have stamps that the session has already. It is
/// reported once, not for each scan.
bool FrontEndNode::is_replayed(Stamp stamp) {
  const bool is_older_than_run = end_of_resumed_ && stamp <= *end_of_resumed_;
  if (!is_older_than_run && (!previous_ || stamp > previous_->stamp - kReplayTolerance)) {
    scans_replayed_ = 0;
    return false;
  }
  const std::string advice =
      is_older_than_run
          ? "time went back: these scans are not later than the session that they would go on "
            "with; map them without resume, and join the two sessions by merge_sessions"
          : "time went back: the nodes map one drive per start; restart them to map another drive "
            "or to play the same bag again";
  if (scans_replayed_++ == 0) {
    const Stamp last = is_older_than_run ? *end_of_resumed_ : previous_->stamp;
    ROS_ERROR_STREAM(
        advice << " (by " << to_seconds(last - stamp)
               << " s; scans are left out until the time is later than that of the last scan)");
  }
  context_.diagnostics.set_state(Diagnostics::Level::kError, advice);
  context_.diagnostics.set("scans played again", scans_replayed_);
  return true;
}

void FrontEndNode::add_gnss(const nav_msgs::Odometry& message) {
  if (previous_) return;
  const auto position = gnss_position(message, config_.node.base_frame, sensor_frames_);
  if (position) assembler_.add_gnss(*position);
}

/// Uses the initial pose from rviz ("2D Pose Estimate") or from a user. Odometry cannot be moved
/// once it has begun, because other nodes have stored its poses.
void FrontEndNode::set_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string frame = frame_name(message.header.frame_id);
  if (frame != config_.node.map_frame && frame != config_.node.odom_frame) {
    throw InputError("the initial pose is in frame '" + frame + "'; give it in '" +
                     config_.node.map_frame + "' or '" + config_.node.odom_frame + "'");
  }
  const Pose T_odom_base = from_message(message.pose.pose);
  if (previous_) {
    throw InputError(
        "the initial pose comes after the first scan; give it before, or start the nodes again");
  }
  front_end_.set_initial_pose(T_odom_base);
  ROS_INFO_STREAM("the drive begins at " << T_odom_base.translation.transpose() << " m, heading "
                                         << yaw_of(T_odom_base.rotation) << " rad");
}

void FrontEndNode::process(std::vector<AssembledScan> scans) {
  for (const AssembledScan& scan : scans) process(scan);
  if (!scans.empty()) {
    context_.diagnostics.set("scans that lack samples of sensors",
                             assembler_.scans_without_samples());
  }
  const std::size_t left_out = assembler_.scans_without_odometry();
  if (left_out > 0 && limiter_.due("external_odom")) {
    ROS_WARN_STREAM("external_odom gave no pose for "
                    << left_out
                    << " scans so far: it must "
                       "surround the stamps of the scans by samples at most 0.5 s apart");
  }
}

void FrontEndNode::process(const AssembledScan& assembled) {
  if (run_id_.empty()) begin_run();
  // Who was taken before the run was known has not been asked.
  if (!previous_ && is_replayed(assembled.scan.stamp)) return;
  const front_end::FrontEndResult result = front_end_.process(assembled.scan, assembled.prior);
  for (const front_end::FrontEndResult& finalized : result.finalized) publish_final(finalized);
  publish_odometry(result);
  if (!result.provisional) publish_final(result);
  publish_clouds(result, assembled);
  report(result);
  previous_ = result;
}

/// No scan has arrived for a while, so the provisional scans become final.
void FrontEndNode::finalize() {
  for (const front_end::FrontEndResult& finalized : front_end_.finalize()) publish_final(finalized);
}

/// Publishes a final result; subscribers store it.
void FrontEndNode::publish_final(const front_end::FrontEndResult& result) {
  if (result.key_frame) {
    key_frame_.publish(
        to_message(*result.key_frame, run_id_, config_.node.base_frame, p_base_lidar_));
  }
  const auto dropped =
      scans_lost_upstream_ + static_cast<std::uint32_t>(context_.worker.losses("synced_cloud"));
  status_.publish(to_message(result, dropped, config_.node.base_frame));
}

/// A restarted front end continues the run of the back end, so that indices of different runs are
/// never mixed; otherwise it starts a new run.
void FrontEndNode::begin_run() {
  const auto state = back_end_.wait_for_run();
  run_id_ = state && !state->run_id.empty() ? state->run_id : dated_name(ros::WallTime::now().sec);
  if (!state || state->key_frames.empty()) return;
  const KeyFrame& last = state->key_frames.back();
  front_end_.resume(last.index + 1, last.segment + 1, last.T_odom_base);
  end_of_resumed_ = last.stamp;
  ROS_WARN_STREAM("continuing run " << run_id_ << " at key frame " << last.index + 1
                                    << ", in a new segment of the trajectory");
}

void FrontEndNode::publish_odometry(const front_end::FrontEndResult& result) {
  const NodeFields& frames = config_.node;
  transform_.send(result.T_odom_base, result.stamp);
  double seconds = 0.0;
  // No motion leads into a new segment, so its first scan has no covariance of one.
  if (previous_ && previous_->segment == result.segment)
    seconds = to_seconds(result.stamp - previous_->stamp);
  laser_odom_.publish(to_odometry(result, front_end_.pose_covariance(), seconds, frames.odom_frame,
                                  frames.base_frame));
}

void FrontEndNode::publish_clouds(const front_end::FrontEndResult& result,
                                  const AssembledScan& assembled) {
  if (current_scan_.getNumSubscribers() > 0) {
    const PointCloud scan = front_end::corrected_cloud(
        assembled.scan.cloud, assembled.prior.uneven_turning, T_base_scan_, result);
    current_scan_.publish(to_message(scan, result.stamp, config_.node.base_frame));
  }
  if (result.key_frame) publish_local_map(result.stamp);
}

/// `stamp` is that of the newest scan in it.
void FrontEndNode::publish_local_map(Stamp stamp) {
  if (local_map_.getNumSubscribers() == 0) return;
  local_map_.publish(to_message(front_end_.local_map(), stamp, config_.node.odom_frame));
}

void FrontEndNode::report(const front_end::FrontEndResult& result) {
  const front_end::TrackingState state = result.status.state;
  const bool poor = !front_end::claims_pose(state) || state == front_end::TrackingState::kDoubtful;
  context_.diagnostics.count_output(result.stamp);
  context_.diagnostics.set_state(poor ? Diagnostics::Level::kWarning : Diagnostics::Level::kOk,
                                 front_end::to_string(state));
  show_figures(result.status);
  const double shift = result.status.elevation_shift;
  if (shift != (previous_ ? previous_->status.elevation_shift : 0.0)) {
    ROS_INFO_STREAM(front_end::elevation_message(shift));
  }
  for (const auto& [key, text] : front_end::warnings_of(result.status)) {
    if (limiter_.due(key)) ROS_WARN_STREAM(text);
  }
  if (result.status.repeated) {
    warn_of_repetition();
  } else if (poor) {
    warn_of_match(result.status);
  }
}

void FrontEndNode::show_figures(const front_end::FrontEndStatus& status) {
  context_.diagnostics.set("probability of the step", status.probability);
  context_.diagnostics.set("seconds per scan", status.seconds);
  if (status.map_points_dropped > 0) {
    context_.diagnostics.set("points without room in the local map", status.map_points_dropped);
  }
  if (status.sweep_times.source != front_end::SweepTimes::kAsGiven) {
    context_.diagnostics.set("times of the points",
                             front_end::to_string(status.sweep_times.source));
  }
  if (status.vertical_ride_distance > 0.0) {
    context_.diagnostics.set("vertical distance not observed by the points, m",
                             status.vertical_ride_distance);
  }
}

void FrontEndNode::warn_of_repetition() {
  if (!limiter_.due("repeated")) return;
  ROS_WARN(
      "the LiDAR's driver sent the same scan again with a new stamp; the pose is a prediction "
      "until new points arrive");
}

void FrontEndNode::warn_of_match(const front_end::FrontEndStatus& status) {
  const char* const state = front_end::to_string(status.state);
  if (!limiter_.due(state)) return;
  ROS_WARN_STREAM("odometry is " << state << ": overlap " << status.overlap << ", fitness "
                                 << status.fitness << " m^2, probability that the step is right "
                                 << status.probability);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::FrontEndNode>(argc, argv);
}
