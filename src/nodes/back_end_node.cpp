#include <cstdlib>
#include <ctime>
#include <deque>
#include <future>

#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/transforms.hpp"

#include "back_end_node_config.hpp"

namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;

/// Measurements that come before the first key frame, or after the last one that is to come.
constexpr std::size_t kEarlyMeasurements = 1000;
/// Files are brought up to date when nothing has come for so long.
constexpr std::chrono::milliseconds kIdle{2000};

fs::path expanded(const std::string& path) {
  const char* home = std::getenv("HOME");
  if (path.empty() || path[0] != '~' || home == nullptr) return path;
  return home + path.substr(1);
}

/// Position and attitude of `T_map_base` with the covariance and the twist of odometry.
nav_msgs::Odometry moved(const nav_msgs::Odometry& odometry, const Pose& T_map_odom,
                         const std::string& map_frame) {
  nav_msgs::Odometry message = odometry;
  message.header.frame_id = map_frame;
  message.pose.pose = to_message(T_map_odom * from_message(odometry.pose.pose));
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = T_map_odom.rotation_matrix();
  rotation.bottomRightCorner<3, 3>() = T_map_odom.rotation_matrix();
  message.pose.covariance =
      to_array(rotation * from_array(odometry.pose.covariance) * rotation.transpose());
  return message;
}

session::ScanRecord to_record(const FrontEndStatusMessage& status) {
  return {from_ros(status.header.stamp),
          status.state,
          status.fitness,
          status.overlap,
          status.seconds,
          std::int64_t{status.scans_dropped}};
}

}  // namespace

/// Subscribed: key_frame, loop, loop_verdict, synced_gnss, synced_imu, floor, gnss_datum,
/// laser_odom, front_end_status. Published: key_frame_poses (latched, whole), optimized_odom,
/// graph_verdict (of all loops to who subscribes, then of those that change), tf map -> odom.
/// Services: optimize_map, get_key_frames. The session's folder stands in the parameter
/// session_folder beside the node.
class BackEndNode {
 public:
  using Config = BackEndNodeConfig;

  BackEndNode(const Config& config, NodeContext& context);
  ~BackEndNode();

 private:
  using Run = pipeline::RecordedBackEnd;
  using OptimizeAnswer = std::promise<back_end::OptimizationReport>;

  void subscribe_all();
  void serve();
  template <typename Message, typename Handle>
  void listen(const std::string& topic, Handle handle, Numbered numbered = Numbered::kNo);

  void take_key_frame(const KeyFrameMessage& message);
  void keep_sensor_origin();
  void take_loop(const LoopMessage& message);
  void take_gnss(const nav_msgs::Odometry& message);
  void take_odometry(const nav_msgs::Odometry& message);
  void measure(std::function<void(Run&)> add);

  void begin_run(const std::string& run_id);
  void use(session::Session session, const std::string& run_id);
  std::optional<session::Session> session_of(const std::string& run_id) const;
  void keep_configuration();

  void optimize_if_due();
  void start_solving(bool thorough);
  void take_solution(const back_end::OptimizationSolution& solution, double seconds,
                     const std::shared_ptr<Run>& solved_run);
  void take_failure(const std::string& problem);
  void end_solving(const back_end::OptimizationReport& report);
  void publish_poses();
  void publish_verdicts(const std::vector<LoopVerdict>& verdicts);
  void write_files();

  bool optimize_map(OptimizeMap::Request& request, OptimizeMap::Response& response);
  bool get_key_frames(GetKeyFrames::Request& request, GetKeyFrames::Response& response);
  GetKeyFrames::Response key_frames_without_clouds(const std::vector<KeyFrameIndex>& wanted);

  Config config_;
  NodeContext& context_;
  SensorFrames sensor_frames_;
  TransformPublisher transforms_;
  Stamp sent_transform_ = 0;
  WarningLimiter limiter_;
  ros::Publisher poses_, optimized_odom_, verdicts_;
  std::vector<ros::Subscriber> subscribers_;

  // The worker's own: the graph, the session, and what waits for an optimisation.
  std::shared_ptr<Run> run_;
  std::string run_id_;
  std::deque<std::function<void(Run&)>> early_;
  std::optional<GeodeticDatum> datum_;
  bool solving_ = false;
  std::vector<OptimizeAnswer> answers_;  ///< to be given after the optimisation that runs
  std::vector<OptimizeAnswer> next_answers_;
  bool files_are_old_ = false;

  Worker::ChannelId requests_, solutions_;
  Worker solver_;
  Worker::ChannelId problems_;
  ros::CallbackQueue service_queue_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner service_spinner_{2, &service_queue_};
};

BackEndNode::BackEndNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      poses_(context.node.advertise<KeyFramePosesMessage>("key_frame_poses", 1, true)),
      optimized_odom_(
          context.node.advertise<nav_msgs::Odometry>("optimized_odom", kPublisherQueue)),
      requests_(context.worker.add_channel("requests", kPublisherQueue)),
      solutions_(context.worker.add_channel("solutions", kPublisherQueue)),
      solver_([](const std::string&, const std::string& what) {
        ROS_ERROR_STREAM("optimisation failed: " << what);
      }),
      problems_(solver_.add_channel("problems", 1)) {
  if (!config.resume.empty()) {
    const fs::path root = expanded(config.session_directory);
    const fs::path path = config.resume == "latest" ? root / "latest" : expanded(config.resume);
    auto session = session::Session::open(path, session::Session::Access::kWrite);
    const std::string run_id = session.run_id();
    use(std::move(session), run_id);
  }
  context.worker.set_on_stop(Worker::OnStop::kDrain);
  context.worker.set_idle_task(kIdle, [this] { write_files(); });
  subscribe_all();
  serve();
}

BackEndNode::~BackEndNode() {
  answers_.clear();  // who waits for an answer learns that there will be none
  next_answers_.clear();
  service_spinner_.stop();
  solver_.stop();
  try {
    write_files();
  } catch (const Error& error) {
    ROS_ERROR_STREAM(error.what());
  }
}

template <typename Message, typename Handle>
void BackEndNode::listen(const std::string& topic, Handle handle, Numbered numbered) {
  subscribers_.push_back(subscribe<Message>(
      context_, topic, config_.node.queue_size,
      [handle](const boost::shared_ptr<const Message>& message) { handle(*message); }, numbered));
}

void BackEndNode::subscribe_all() {
  listen<KeyFrameMessage>(
      "key_frame", [this](const auto& m) { take_key_frame(m); }, Numbered::kYes);
  listen<LoopMessage>(
      "loop", [this](const auto& m) { take_loop(m); }, Numbered::kYes);
  listen<LoopVerdictMessage>("loop_verdict", [this](const auto& m) {
    if (run_ && m.run_id == run_id_) run_->session().add_verdict(from_message(m));
  });
  listen<nav_msgs::Odometry>("synced_gnss", [this](const auto& m) { take_gnss(m); });
  listen<sensor_msgs::Imu>("synced_imu", [this](const auto& m) {
    measure([sample = from_message(m)](Run& run) { run.add_imu(sample); });
  });
  listen<FloorMessage>("floor", [this](const auto& m) {
    measure([floor = from_message(m)](Run& run) { run.add_floor(floor); });
  });
  listen<sensor_msgs::NavSatFix>("gnss_datum", [this](const auto& m) {
    datum_ = GeodeticDatum{m.latitude, m.longitude, m.altitude};
    if (run_) run_->session().set_datum(*datum_);
  });
  listen<nav_msgs::Odometry>("laser_odom", [this](const auto& m) { take_odometry(m); });
  listen<FrontEndStatusMessage>("front_end_status", [this](const auto& m) {
    measure([record = to_record(m)](Run& run) { run.session().add_scan(record); });
  });
  const auto channel = context_.worker.add_channel("subscribers", kPublisherQueue);
  verdicts_ = context_.node.advertise<LoopVerdictMessage>("graph_verdict", 10 * kPublisherQueue,
                                                          [this, channel](const auto&) {
                                                            context_.worker.post(channel, [this] {
                                                              if (run_)
                                                                publish_verdicts(run_->verdicts());
                                                            });
                                                          });
}

/// Services wait for the worker, so they have threads of their own.
void BackEndNode::serve() {
  ros::NodeHandle node(context_.node);
  node.setCallbackQueue(&service_queue_);
  services_ = {node.advertiseService("optimize_map", &BackEndNode::optimize_map, this),
               node.advertiseService("get_key_frames", &BackEndNode::get_key_frames, this)};
  service_spinner_.start();
}

void BackEndNode::take_key_frame(const KeyFrameMessage& message) {
  if (!run_ || message.run_id != run_id_) begin_run(message.run_id);
  const KeyFrame key_frame = from_message(message);
  context_.diagnostics.count_input(key_frame.stamp);
  run_->add_key_frame(key_frame);
  files_are_old_ = true;
  keep_sensor_origin();
  context_.diagnostics.set("key frames", std::to_string(key_frame.index + 1));
  optimize_if_due();
}

void BackEndNode::keep_sensor_origin() {
  if (config_.lidar_frame.empty() || run_->session().sensor_origin()) return;
  const auto T_base_lidar = sensor_frames_.lookup(config_.node.base_frame, config_.lidar_frame);
  if (T_base_lidar) run_->session().set_sensor_origin(T_base_lidar->translation);
}

void BackEndNode::take_loop(const LoopMessage& message) {
  if (!run_ || message.run_id != run_id_) {
    throw InputError("the loop belongs to run '" + message.run_id + "', this is run '" + run_id_ +
                     "'; start loop_closing_node again if it lasts");
  }
  if (!run_->add_loop(from_message(message))) {
    throw InputError("the loop from key frame " + std::to_string(message.from) + " to " +
                     std::to_string(message.to) + " does not fit the graph");
  }
  files_are_old_ = true;
  optimize_if_due();
}

void BackEndNode::take_gnss(const nav_msgs::Odometry& message) {
  const auto T_base_antenna =
      sensor_frames_.lookup(config_.node.base_frame, message.child_frame_id);
  if (!T_base_antenna) {
    throw InputError("no transform from '" + message.child_frame_id + "' to '" +
                     config_.node.base_frame + "': the antenna's place is not known");
  }
  const GnssPosition position = from_message(message, T_base_antenna->translation);
  measure([position](Run& run) { run.add_gnss(position); });
}

/// tf and odometry in the map, at the stamp of the odometry; never twice for one stamp.
void BackEndNode::take_odometry(const nav_msgs::Odometry& message) {
  const Stamp stamp = from_ros(message.header.stamp);
  const Pose T_odom_base = from_message(message.pose.pose);
  measure([stamp, T_odom_base](Run& run) { run.session().add_odometry(stamp, T_odom_base); });
  const Pose T_map_odom = run_ ? run_->T_map_odom() : Pose::Identity();
  optimized_odom_.publish(moved(message, T_map_odom, config_.node.map_frame));
  if (stamp <= sent_transform_) return;
  transforms_.send(T_map_odom, stamp, config_.node.map_frame, config_.node.odom_frame);
  sent_transform_ = stamp;
}

/// A measurement may come before the first key frame, by which the run is known.
void BackEndNode::measure(std::function<void(Run&)> add) {
  if (run_) return add(*run_);
  early_.push_back(std::move(add));
  if (early_.size() > kEarlyMeasurements) early_.pop_front();
}

/// The run that this node knew before it was killed is gone on with; any other gets a session of
/// its own.
void BackEndNode::begin_run(const std::string& run_id) {
  if (run_) write_files();
  run_.reset();  // lets go of its session before another is opened
  if (auto session = session_of(run_id)) {
    use(std::move(*session), run_id);
  } else {
    use(session::Session::create(expanded(config_.session_directory), std::time(nullptr)), run_id);
  }
  for (const auto& add : early_) add(*run_);
  early_.clear();
}

/// The newest session, if it is one of that run.
std::optional<session::Session> BackEndNode::session_of(const std::string& run_id) const {
  const fs::path latest = expanded(config_.session_directory) / "latest";
  if (!fs::exists(latest / "session.db")) return std::nullopt;
  try {
    auto session = session::Session::open(latest, session::Session::Access::kWrite);
    if (session.run_id() == run_id) return session;
  } catch (const FileError& error) {
    ROS_WARN_STREAM("beginning a new session: " << error.what());
  }
  return std::nullopt;
}

void BackEndNode::use(session::Session session, const std::string& run_id) {
  const std::size_t known = session.key_frame_count();
  run_ = std::make_shared<Run>(std::move(session), config_.stage);
  run_id_ = run_id;
  run_->session().set_run_id(run_id);
  if (datum_) run_->session().set_datum(*datum_);
  const std::string folder = run_->session().directory().string();
  context_.node.setParam("session_folder", folder);
  context_.diagnostics.set("session", folder);
  ROS_INFO_STREAM((known > 0 ? "going on with session " : "session ") << folder);
  if (known == 0) return;
  ROS_INFO_STREAM(known << " key frames of run " << run_id << " are there already");
  publish_poses();
}

void BackEndNode::optimize_if_due() {
  if (!solving_ && run_->optimization_due()) start_solving(false);
}

void BackEndNode::start_solving(bool thorough) {
  solving_ = true;
  context_.diagnostics.set_state(Diagnostics::Level::kOk, "optimising");
  solver_.post(problems_, [this, problem = run_->problem(thorough), run = run_] {
    const ros::WallTime begin = ros::WallTime::now();
    std::shared_ptr<const back_end::OptimizationSolution> solution;
    std::string problem_text;
    try {
      solution = back_end::solve(*problem);
    } catch (const std::exception& error) {
      problem_text = error.what();
    }
    const double seconds = (ros::WallTime::now() - begin).toSec();
    context_.worker.post(solutions_, [this, solution, seconds, run, problem_text] {
      solution ? take_solution(*solution, seconds, run) : take_failure(problem_text);
    });
  });
}

void BackEndNode::take_solution(const back_end::OptimizationSolution& solution, double seconds,
                                const std::shared_ptr<Run>& solved_run) {
  back_end::OptimizationReport report = back_end::report_of(solution);
  report.seconds = seconds;
  if (solved_run == run_) {
    const pipeline::AppliedSolution applied = run_->apply(solution, seconds);
    files_are_old_ = true;
    publish_poses();
    publish_verdicts(applied.verdicts);
  }
  context_.diagnostics.set("loops used", std::to_string(report.loops_used));
  context_.diagnostics.set("loops refused", std::to_string(report.loops_refused));
  context_.diagnostics.set("GNSS positions used", std::to_string(report.gnss_used));
  context_.diagnostics.set("seconds per optimisation", std::to_string(seconds));
  end_solving(report);
}

/// The poses stay as they were.
void BackEndNode::take_failure(const std::string& problem) {
  back_end::OptimizationReport report;
  report.message = "the optimisation failed: " + problem;
  ROS_ERROR_STREAM(report.message);
  end_solving(report);
}

/// Gives the answers that waited for this optimisation, and begins the next that was asked for.
void BackEndNode::end_solving(const back_end::OptimizationReport& report) {
  solving_ = false;
  context_.diagnostics.set_state(Diagnostics::Level::kOk, report.message);
  if (!answers_.empty()) write_files();
  for (OptimizeAnswer& answer : answers_) answer.set_value(report);
  answers_ = std::move(next_answers_);
  next_answers_.clear();
  if (!answers_.empty()) start_solving(true);
}

void BackEndNode::publish_poses() {
  const KeyFramePoses poses = run_->poses();
  if (poses.poses.empty()) return;
  context_.diagnostics.count_output(poses.poses.back().stamp);
  poses_.publish(to_message(poses, run_id_, config_.node.map_frame));
}

void BackEndNode::publish_verdicts(const std::vector<LoopVerdict>& verdicts) {
  for (const LoopVerdict& verdict : verdicts) {
    verdicts_.publish(to_message(verdict, run_id_, config_.node.base_frame));
  }
}

void BackEndNode::write_files() {
  if (!run_ || !files_are_old_) return;
  keep_configuration();
  run_->write_files();
  files_are_old_ = false;
}

void BackEndNode::keep_configuration() {
  if (!ros::ok()) return;  // the parameter server may be gone
  for (const auto& [stage, yaml] : effective_configurations(context_.node)) {
    run_->session().set_configuration(stage, yaml);
  }
}

bool BackEndNode::optimize_map(OptimizeMap::Request&, OptimizeMap::Response& response) {
  auto answer = std::make_shared<OptimizeAnswer>();
  std::future<back_end::OptimizationReport> future = answer->get_future();
  context_.worker.post(requests_, [this, answer] {
    if (!run_) {
      back_end::OptimizationReport report;
      report.message = "there are no key frames yet; nothing to optimise";
      return answer->set_value(report);
    }
    (solving_ ? next_answers_ : answers_).push_back(std::move(*answer));
    if (!solving_) start_solving(true);
  });
  answer.reset();
  try {
    const back_end::OptimizationReport report = future.get();
    response.success = report.success;
    response.message = report.message;
    response.key_frames = static_cast<std::uint32_t>(report.key_frames);
    response.loops_used = static_cast<std::uint32_t>(report.loops_used);
    response.loops_refused = static_cast<std::uint32_t>(report.loops_refused);
    response.gnss_used = static_cast<std::uint32_t>(report.gnss_used);
    response.gnss_refused = static_cast<std::uint32_t>(report.gnss_refused);
    response.cost_before = report.cost_before;
    response.cost_after = report.cost_after;
    response.seconds = report.seconds;
  } catch (const std::future_error&) {
    response.success = false;
    response.message = "the back end is ending";
  }
  return true;
}

bool BackEndNode::get_key_frames(GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
  struct Answer {
    GetKeyFrames::Response response;
    std::shared_ptr<Run> run;  ///< keeps the store of the clouds while they are read
  };
  auto answer = std::make_shared<std::promise<Answer>>();
  std::future<Answer> future = answer->get_future();
  context_.worker.post(requests_, [this, answer, wanted = request.indices] {
    answer->set_value({key_frames_without_clouds(wanted), run_});
  });
  answer.reset();
  try {
    Answer given = future.get();
    response = std::move(given.response);
    if (!request.clouds || !given.run) return true;
    for (KeyFrameMessage& message : response.key_frames) {
      const PointCloudPtr cloud = given.run->session().clouds().cloud(message.index);
      if (!cloud) continue;
      message.cloud = to_message(*cloud, from_ros(message.header.stamp), config_.node.base_frame);
    }
    return true;
  } catch (const std::future_error&) {
    return false;
  }
}

GetKeyFrames::Response BackEndNode::key_frames_without_clouds(
    const std::vector<KeyFrameIndex>& wanted) {
  GetKeyFrames::Response response;
  if (!run_) return response;
  for (const KeyFrame& key_frame : run_->session().key_frames()) {
    if (!wanted.empty() &&
        std::find(wanted.begin(), wanted.end(), key_frame.index) == wanted.end()) {
      continue;
    }
    response.key_frames.push_back(to_message(key_frame, run_id_, config_.node.base_frame));
  }
  response.poses = to_message(run_->poses(), run_id_, config_.node.map_frame);
  return response;
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::BackEndNode>(argc, argv,
                                                                                     "back_end");
}
