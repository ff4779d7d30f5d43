// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/loop_closing/method_substitution.hpp"
#include "lidar_mapping/pipeline/datum.hpp"
#include "lidar_mapping/ros/key_frame_client.hpp"
#include "lidar_mapping/ros/line_limiter.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/repeating_publisher.hpp"
#include "lidar_mapping/ros/scratch_folder.hpp"
#include "lidar_mapping/ros/transforms.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

#include "session_frame.hpp"
#include "unclaimed_positions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Number of loops that are sent again to a restarted back end. Chosen: far above those that are
/// found in the seconds of a restart.
constexpr std::uint32_t kRepeatedLoops = 100;
/// Idle time after which the newest count of loops is logged.
constexpr std::chrono::milliseconds kIdle{10000};

/// A line for the log: the count so far, and the newest loop.
std::string loop_summary(const Loop& loop, std::size_t count) {
  return formatted(
      "loops: %zu; the newest one: key frame %u at the place of key frame %u, overlap %.2f, "
      "fitness "
      "%.2g m^2",
      count, loop.to, loop.from, loop.overlap, loop.fitness);
}

void log_line(const std::optional<std::string>& line) {
  if (line) ROS_INFO_STREAM(*line);
}

}  // namespace

/// Subscribed: key_frame, key_frame_poses, synced_gnss, gnss_datum. Published: loop, loop_verdict.
/// Asks get_key_frames for what it missed; a restart loses nothing.
class LoopClosingNode {
 public:
  using Config = LidarNodeConfig<loop_closing::LoopClosingConfig>;

  LoopClosingNode(const Config& config, NodeContext& context);
  ~LoopClosingNode() {
    if (const auto line = loop_log_.rest()) print_at_exit(*line);
  }

 private:
  /// Clouds of one run and the search in them.
  struct Run {
    Run(const Config& config, const std::filesystem::path& folder)
        : clouds(folder), closer(config.stage, clouds, folder) {}
    session::CloudStore clouds;
    loop_closing::LoopCloser closer;
  };

  void begin_run(const std::string& run_id);
  void restore_graph();
  void add_key_frame(const ReceivedKeyFrame& received);
  void update_sensor_origin(const ReceivedKeyFrame& received);
  void update_poses(const KeyFramePosesMessage& message);
  void add_gnss(const nav_msgs::Odometry& message);
  void add_to_run(const GnssPosition& position);
  void publish(const loop_closing::LoopClosingResult& result);
  void report();

  Config config_;
  NodeContext& context_;
  ScratchFolder scratch_{ros::this_node::getName()};
  SensorFrames sensor_frames_;
  std::string run_id_;
  std::size_t runs_ = 0;
  std::unique_ptr<Run> run_;
  KeyFrameClient back_end_;
  PoseFeed poses_;
  SessionFrame session_frame_;
  UnclaimedPositions gnss_;             ///< in the axes of the drive
  std::optional<RunState> stored_run_;  ///< of a resumed run, until its key frames are restored
  std::size_t accepted_ = 0;
  std::size_t refused_ = 0;
  LineLimiter loop_log_;
  RepeatingPublisher<LoopMessage> loop_;
  ros::Publisher verdict_;
  KeyFrameSubscription key_frames_;
  std::vector<ros::Subscriber> subscribers_;
};

LoopClosingNode::LoopClosingNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      back_end_(context.node),
      poses_([this] { return back_end_.poses(); }),
      session_frame_(context.node),
      loop_(context.node, "loop", kRepeatedLoops),
      verdict_(context.node.advertise<LoopVerdictMessage>("loop_verdict", kPublisherQueue)),
      key_frames_(context, config.node.queue_size,
                  [this](const ReceivedKeyFrame& received) { add_key_frame(received); }) {
  const std::string notice = loop_closing::describe_substitution(config.stage.registration_method);
  if (!notice.empty()) ROS_INFO_STREAM(notice);
  subscribers_ = {
      subscribe_numbered<KeyFramePosesMessage>(
          context, "key_frame_poses", config.node.queue_size,
          [this](const auto& message) { update_poses(*message); }),
      subscribe<nav_msgs::Odometry>(context, "synced_gnss", config.node.queue_size,
                                    [this](const auto& message) { add_gnss(*message); }),
      subscribe<sensor_msgs::NavSatFix>(context, "gnss_datum", 1, [this](const auto& message) {
        session_frame_.set_drive_datum({message->latitude, message->longitude, message->altitude});
      })};
  context.worker.set_idle_task(kIdle, [this] { log_line(loop_log_.rest()); });
}

void LoopClosingNode::begin_run(const std::string& run_id) {
  run_id_ = run_id;
  run_ = std::make_unique<Run>(config_, scratch_.path() / std::to_string(++runs_));
  session_frame_.begin_run(run_id);
  for (const GnssPosition& position : gnss_.positions()) add_to_run(position);
  stored_run_ = back_end_.run();
  if (stored_run_ && stored_run_->run_id != run_id) stored_run_.reset();
  if (stored_run_) poses_.push({run_id, stored_run_->poses});
  run_->closer.update_poses(poses_.known(run_id));
}

/// Restores loops, positions and poses after all old key frames have been restored. Poses may have
/// moved since these were fetched.
void LoopClosingNode::restore_graph() {
  run_->closer.restore(stored_run_->loops, stored_run_->gnss, poses_.known(run_id_));
  if (stored_run_->searched > 0) {
    ROS_INFO_STREAM("continuing at key frame " << stored_run_->searched << " with "
                                               << stored_run_->loops.size() << " known loops");
  }
  stored_run_.reset();
}

void LoopClosingNode::add_key_frame(const ReceivedKeyFrame& received) {
  if (!run_ || received.run_id != run_id_) begin_run(received.run_id);
  const KeyFrame& key_frame = received.key_frame;
  context_.diagnostics.count_input(key_frame.stamp);
  update_sensor_origin(received);
  if (key_frame.cloud) run_->clouds.put(key_frame.index, key_frame.cloud);
  if (stored_run_ && key_frame.index >= stored_run_->searched) restore_graph();
  if (stored_run_) {
    run_->closer.restore(key_frame);
  } else {
    publish(run_->closer.process(key_frame));
  }
  gnss_.drop_until(key_frame.stamp);
  context_.diagnostics.count_output(key_frame.stamp);
  report();
}

void LoopClosingNode::update_sensor_origin(const ReceivedKeyFrame& received) {
  auto origin = sensor_frames_.origin_of(config_.lidar_frame, config_.node.base_frame);
  if (!origin) origin = received.p_base_lidar;
  if (origin) run_->closer.set_sensor_origin(*origin);
}

/// The key frames come first, because they may begin a run, for which newer poses are fetched.
void LoopClosingNode::update_poses(const KeyFramePosesMessage& message) {
  const RunPoses received{message.run_id, from_message(message)};
  key_frames_.note(received.indices());
  const auto changed = poses_.push(received);
  if (changed && run_ && changed->run_id == run_id_) run_->closer.update_poses(changed->poses);
}

void LoopClosingNode::add_gnss(const nav_msgs::Odometry& message) {
  const auto position = gnss_position(message, config_.node.base_frame, sensor_frames_);
  if (!position) return;
  gnss_.add(*position);
  if (run_) add_to_run(*position);
}

/// Positions that are restored from the session are in its axes already.
void LoopClosingNode::add_to_run(const GnssPosition& position) {
  run_->closer.add_gnss(pipeline::transformed_position(position, session_frame_.T_session_drive()));
}

void LoopClosingNode::publish(const loop_closing::LoopClosingResult& result) {
  for (const Loop& loop : result.loops) {
    loop_.publish(to_message(loop, run_id_, config_.node.base_frame));
    log_line(loop_log_.add(loop_summary(loop, ++accepted_), ros::WallTime::now().toSec()));
  }
  for (const LoopVerdict& verdict : result.verdicts) {
    verdict_.publish(to_message(verdict, run_id_, config_.node.base_frame));
    if (verdict.verdict == Verdict::kRefused) ++refused_;
  }
}

void LoopClosingNode::report() {
  context_.diagnostics.set_state(Diagnostics::Level::kOk, "searching");
  context_.diagnostics.set("key frames", key_frames_.feed().next_index());
  context_.diagnostics.set("key frames given up", key_frames_.feed().missing());
  context_.diagnostics.set("loops accepted", accepted_);
  context_.diagnostics.set("candidates refused", refused_);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::LoopClosingNode>(argc,
                                                                                         argv);
}
