// SPDX-License-Identifier: BSD-3-Clause
#include "back_end_node.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "scan_record.hpp"
#include "session_frame.hpp"
#include "worker_tasks.hpp"

// Received messages, the run that they belong to, and its session.
namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;

/// Largest number of measurements that are kept until the first key frame arrives. Chosen: more
/// than a minute of scans with GNSS at 10 Hz; bounds the memory.
constexpr std::size_t kEarlyMeasurements = 1000;
/// Largest number of loops that are kept until their key frames arrive: a node that starts receives
/// both again. Chosen: ten times those of a town that is driven twice; bounds the memory.
constexpr std::size_t kEarlyLoops = 1000;
/// Idle time after which the files of the session are updated.
constexpr std::chrono::milliseconds kIdle{2000};

/// Position and attitude of `T_map_base` with the covariance and the twist of odometry.
nav_msgs::Odometry moved(const nav_msgs::Odometry& odometry, const Pose& T_map_odom,
                         const std::string& map_frame) {
  nav_msgs::Odometry message = odometry;
  message.header.frame_id = map_frame;
  message.pose.pose = to_message(T_map_odom * from_message(odometry.pose.pose));
  message.pose.covariance =
      to_array(in_parent_axes(from_array(odometry.pose.covariance), T_map_odom));
  return message;
}

}  // namespace

BackEndNode::BackEndNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      transform_(context, config.node.map_frame, config.node.odom_frame),
      poses_(context.node, config.node.map_frame),
      optimized_odom_(
          context.node.advertise<nav_msgs::Odometry>("optimized_odom", kPublisherQueue)),
      key_frames_([](const auto&) { return std::vector<ReceivedKeyFrame>(); },
                  [this](const ReceivedKeyFrame& received) { add_key_frame(received); },
                  [this](const std::string& run_id) { return continue_run(run_id); }),
      requests_(context.worker.add_channel("requests", kPublisherQueue)),
      loops_(context.worker.add_channel("early loops", kEarlyLoops)),
      solver_(context.worker, [this](const SolvedProblem& solved) {
        solved.solution ? apply_solution(solved) : report_failure(solved.failure);
      }) {
  advertise_verdicts();
  resume();
  if (!run_) check_session_directory();
  context.worker.drain_on_stop();
  context.worker.set_idle_task(kIdle, [this] {
    finalize();
    write_files();
  });
  subscribe_all();
  advertise_services();
  context.node.deleteParam(kRunResuming);
}

void BackEndNode::advertise_verdicts() {
  const auto channel = context_.worker.add_channel("subscribers", kPublisherQueue);
  const auto publish_all = [this] {
    if (run_) publish_verdicts(run_->verdicts());
  };
  // A new subscriber is told of all loops at once.
  verdicts_ = advertise<LoopVerdictMessage>(context_, "graph_verdict", kUnlimitedQueue, channel,
                                            publish_all);
}

/// Opens the session that this node had before it was killed, otherwise the one of the parameter
/// `resume`.
void BackEndNode::resume() {
  std::string folder;
  const bool was_killed =
      context_.node.getParam(kRunSession, folder) && fs::exists(fs::path(folder) / "session.db");
  if (!was_killed && config_.resume.empty()) return;
  context_.node.setParam(kRunResuming, ros::this_node::getName());
  const fs::path asked = config_.resume == "latest"
                             ? expanded_path(config_.session_directory) / "latest"
                             : expanded_path(config_.resume);
  continue_session(session::Session::open(was_killed ? fs::path(folder) : asked,
                                          session::Session::Access::kWrite));
  resumed_run_ = run_id_;
}

/// A drive of which nothing can be stored is not begun.
void BackEndNode::check_session_directory() const {
  try {
    NamelessFile(expanded_path(config_.session_directory)).write(0, "", 1);
  } catch (const FileError& error) {
    throw ConfigError("session_directory: " + std::string(error.what()) + ", or name another one");
  }
}

/// A session that no node has made, but map_bag, belongs to no run yet.
void BackEndNode::continue_session(session::Session session) {
  std::string run_id = session.run_id();
  if (run_id.empty()) run_id = fs::canonical(session.directory()).filename().string();
  set_session(std::move(session), run_id);
}

BackEndNode::~BackEndNode() {
  for (const char* name : {kRunSession, kSessionDatum}) context_.node.deleteParam(name);
  solver_.drop_requests();
  service_spinner_.stop();
  solver_.stop();
  try {
    finalize();
    write_files();
    print_session();
  } catch (const std::exception& error) {
    print_at_exit(error.what());
  }
}

template <typename Message, typename Handle>
void BackEndNode::listen(const std::string& topic, Handle handle) {
  subscribers_.push_back(subscribe_numbered<Message>(
      context_, topic, config_.node.queue_size,
      [handle](const boost::shared_ptr<const Message>& message) { handle(*message); }));
}

void BackEndNode::subscribe_all() {
  listen<KeyFrameMessage>("key_frame", [this](const auto& m) { receive_key_frame(m); });
  listen<LoopMessage>("loop", [this](const auto& m) { add_loop(m); });
  listen<LoopVerdictMessage>("loop_verdict", [this](const auto& m) { add_verdict(m); });
  listen<nav_msgs::Odometry>("synced_gnss", [this](const auto& m) { add_gnss(m); });
  listen<sensor_msgs::Imu>("synced_imu", [this](const auto& m) {
    add_or_queue([sample = from_message(m)](Run& run) { run.add_imu(sample); });
  });
  listen<FloorMessage>("floor", [this](const auto& m) {
    add_or_queue([floor = from_message(m)](Run& run) { run.add_floor(floor); });
  });
  subscribers_.push_back(subscribe<sensor_msgs::NavSatFix>(
      context_, "gnss_datum", config_.node.queue_size, [this](const auto& m) {
        datum_ = GeodeticDatum{m->latitude, m->longitude, m->altitude};
        if (!run_) return;
        run_->set_datum(*datum_);
        store_datum();
      }));
  listen<nav_msgs::Odometry>("laser_odom", [this](const auto& m) { publish_in_map(m); });
  listen<FrontEndStatusMessage>("front_end_status", [this](const auto& m) {
    add_or_queue([record = to_record(m)](Run& run) { run.session().add_scan(record); });
  });
}

/// A key frame that cannot be stored is missing in the map; whoever asks for the map is told.
void BackEndNode::receive_key_frame(const KeyFrameMessage& message) try {
  key_frames_.push(received(message));
} catch (const FileError& error) {
  // Of a run that has a session, add_key_frame() knows which one it was.
  if (message.run_id != run_id_) unstored_.add(message.run_id, message.index, error.what());
  report_state();
  throw;
}

/// Returns the first key frame that the session of this run lacks.
KeyFrameIndex BackEndNode::continue_run(const std::string& run_id) {
  if (run_ && run_id != run_id_ && run_id_ == resumed_run_) {
    ROS_ERROR_STREAM("key frames of run '"
                     << run_id << "' arrive, which does not go on with the resumed session '"
                     << run_id_
                     << "': they go into a new session; start the nodes again to go on with it");
  }
  if (!run_ || run_id != run_id_) begin_run(run_id);
  return next_index_;
}

void BackEndNode::add_key_frame(const ReceivedKeyFrame& received) {
  const KeyFrame& key_frame = received.key_frame;
  report_missing();
  context_.diagnostics.count_input(key_frame.stamp);
  next_index_ = key_frame.index + 1;
  try {
    run_->add_key_frame(key_frame);
  } catch (const FileError& error) {
    unstored_.add(run_id_, key_frame.index, error.what());
    throw;
  }
  unstored_.remove(key_frame.index);
  files_outdated_ = true;
  store_sensor_origin(received);
  context_.diagnostics.set("key frames", key_frame.index + 1);
  report_state();
  add_early_loops();
  optimize_if_due();
}

/// Prints the session's folder again at shutdown, because the first message is far up in the log by
/// then.
void BackEndNode::print_session() const {
  if (!run_) return;
  print_at_exit("session " + run_->session().directory().string() + ": " +
                std::to_string(run_->session().key_frame_count()) + " key frames");
}

/// Stops waiting for missing key frames and processes those after them.
void BackEndNode::finalize() {
  key_frames_.flush();
  report_missing();
}

/// Says how many key frames were given up since it last did.
void BackEndNode::report_missing() {
  const std::size_t missing = key_frames_.missing();
  const std::size_t before = std::exchange(reported_missing_, missing);
  context_.diagnostics.set("key frames given up", missing);
  if (missing > before) ROS_WARN_STREAM("key frames that did not arrive: " << missing - before);
}

void BackEndNode::store_sensor_origin(const ReceivedKeyFrame& received) {
  if (run_->session().sensor_origin()) return;
  auto origin = sensor_frames_.origin_of(config_.lidar_frame, config_.node.base_frame);
  if (!origin) origin = received.p_base_lidar;
  if (origin) run_->session().set_sensor_origin(*origin);
}

void BackEndNode::add_loop(const LoopMessage& message) {
  if (!run_ || (message.run_id == run_id_ && std::max(message.from, message.to) >= next_index_)) {
    early_loops_.push_back(message);
    if (early_loops_.size() <= kEarlyLoops) return;
    early_loops_.pop_front();
    return report_dropped("loops that came before their key frames", ++early_loops_dropped_);
  }
  if (message.run_id != run_id_) {
    throw InputError("the loop belongs to run '" + message.run_id + "', this is run '" + run_id_ +
                     "'; restart loop_closing_node if this message continues");
  }
  const Loop loop = from_message(message);
  if (run_->has_loop(loop)) return;
  if (!run_->add_loop(loop)) {
    throw InputError("the loop from key frame " + std::to_string(message.from) + " to " +
                     std::to_string(message.to) + " does not fit the graph");
  }
  files_outdated_ = true;
  optimize_if_due();
}

/// The run is known only at its first key frame, so that an earlier verdict waits for it.
void BackEndNode::add_verdict(const LoopVerdictMessage& message) {
  add_or_queue([this, id = message.run_id, verdict = from_message(message)](Run& run) {
    if (id == run_id_) return run.add_verdict(verdict);
    context_.diagnostics.set("verdicts of other runs", ++foreign_verdicts_);
  });
}

/// The log has the first one alone, because a node that is left out makes it many.
void BackEndNode::report_dropped(const std::string& what, std::size_t count) {
  context_.diagnostics.set(what + ", dropped", count);
  if (count == 1) ROS_WARN_STREAM(what << ": too many wait, the oldest are dropped");
}

void BackEndNode::add_early_loops() {
  const std::deque<LoopMessage> loops = std::exchange(early_loops_, {});
  for (const LoopMessage& loop : loops) {
    context_.worker.post(loops_, [this, loop] { add_loop(loop); });
  }
}

void BackEndNode::add_gnss(const nav_msgs::Odometry& message) {
  const auto position = gnss_position(message, config_.node.base_frame, sensor_frames_);
  if (!position) {
    throw InputError("no transform from '" + message.child_frame_id + "' to '" +
                     config_.node.base_frame + "': the position of the antenna is not known");
  }
  add_or_queue([position = *position](Run& run) { run.add_gnss(position); });
}

/// Publishes tf and odometry in the map at the stamp of the odometry, tf at most once for each
/// stamp.
void BackEndNode::publish_in_map(const nav_msgs::Odometry& message) {
  const Stamp stamp = from_ros(message.header.stamp);
  const Pose T_odom_base = from_message(message.pose.pose);
  add_or_queue([stamp, T_odom_base](Run& run) { run.session().add_odometry(stamp, T_odom_base); });
  const Pose T_map_odom = run_ ? run_->T_map_odom() : Pose::Identity();
  optimized_odom_.publish(moved(message, T_map_odom, config_.node.map_frame));
  if (stamp <= sent_transform_) return;
  transform_.send(T_map_odom, stamp);
  sent_transform_ = stamp;
}

/// Measurements that arrive before the first key frame, which names the run, are queued.
void BackEndNode::add_or_queue(std::function<void(Run&)> add) {
  if (run_) return add(*run_);
  early_.push_back(std::move(add));
  if (early_.size() <= kEarlyMeasurements) return;
  early_.pop_front();
  report_dropped("measurements that came before the first key frame", ++early_dropped_);
}

/// Continues the session of this run if there is one (restart of the node), otherwise creates a new
/// session.
void BackEndNode::begin_run(const std::string& run_id) {
  if (run_) {
    write_files();
    sent_transform_ = 0;  // the stamps of another run may be older
  }
  run_.reset();  // closes its session before another one is opened
  if (auto session = session_of(run_id)) {
    set_session(std::move(*session), run_id);
  } else {
    set_session(
        session::Session::create(expanded_path(config_.session_directory), std::time(nullptr)),
        run_id);
  }
  add_early_measurements();
}

void BackEndNode::add_early_measurements() {
  for (const auto& add : early_) add(*run_);
  early_.clear();
}

/// The newest session, if it belongs to that run.
std::optional<session::Session> BackEndNode::session_of(const std::string& run_id) const {
  const fs::path latest = expanded_path(config_.session_directory) / "latest";
  if (!fs::exists(latest / "session.db")) return std::nullopt;
  try {
    auto session = session::Session::open(latest, session::Session::Access::kWrite);
    if (session.run_id() == run_id) return session;
  } catch (const FileError& error) {
    ROS_WARN_STREAM("beginning a new session: " << error.what());
  }
  return std::nullopt;
}

void BackEndNode::set_session(session::Session session, const std::string& run_id) {
  const std::size_t known = session.key_frame_count();
  auto run = std::make_shared<Run>(std::move(session), config_.stage);
  const KeyFrameIndex next = known > 0 ? run->session().key_frames().back().index + 1 : 0;
  run->session().set_run_id(run_id);
  if (datum_) run->set_datum(*datum_);
  run_ = std::move(run);  // all that may fail has been done
  run_id_ = run_id;
  unstored_.begin_run(run_id);
  poses_.begin_run(run_id);
  next_index_ = next;
  store_datum();
  const std::string folder = run_->session().directory().string();
  context_.node.setParam(kRunSession, folder);
  context_.diagnostics.set("session", folder);
  ROS_INFO_STREAM((known > 0 ? "continuing session " : "session ") << folder);
  if (known == 0) return;
  report_state();
  ROS_INFO_STREAM(known << " key frames of run " << run_id << " exist already");
  files_outdated_ = true;
  publish_poses(run_->poses(), false);
  publish_verdicts(run_->verdicts());
}

/// Other nodes turn the positions of this drive to it.
void BackEndNode::store_datum() {
  const auto datum = run_->session().datum();
  if (datum) store_session_datum(*datum, run_id_, context_.node);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::BackEndNode>(argc, argv);
}
