#include <filesystem>
#include <future>
#include <utility>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/key_frame_client.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/scratch_folder.hpp"
#include "lidar_mapping/session/session.hpp"

#include "drive_display.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Without moved poses the map on display grows in steps of this length of the drive.
constexpr KeyFrameIndex kKeyFramesPerStep = 20;

/// `stage`, with another resolution unless that is 0.
map::MapConfig with_resolution(const map::MapConfig& stage, double resolution) {
  if (resolution == 0.0) return stage;
  return config::load<map::MapConfig>(
      {config::parse_yaml(config::to_yaml(stage), "map"),
       {"save_map", {config::Value::Map{{"resolution", {resolution}}}}}});
}

}  // namespace

/// Subscribed: key_frame, key_frame_poses, loop, loop_verdict, graph_verdict, synced_gnss,
/// gnss_datum, front_end_status, /diagnostics. Published: global_map, odom_path, optimized_path
/// (latched), graph_markers (changes; the whole to who comes). Service: save_map. Asks
/// get_key_frames for what it missed; a restart loses nothing.
class MapViewerNode {
 public:
  using Config = NodeConfig<map::MapConfig>;

  MapViewerNode(const Config& config, NodeContext& context);
  ~MapViewerNode();

 private:
  /// The clouds of one run, and the map of them; both belong to the thread that builds.
  struct Run {
    Run(const map::MapConfig& config, const std::filesystem::path& folder)
        : clouds(folder), builder(config, clouds) {}
    session::CloudStore clouds;
    map::MapBuilder builder;
  };

  ros::Publisher advertise_map();
  void subscribe_all();
  void begin_run(const std::string& run_id);
  void take_key_frame(const RunKeyFrame& received);
  void take_poses(const KeyFramePosesMessage& message);
  void take_loop(const LoopMessage& message);
  void take_candidate(const LoopVerdictMessage& message);
  void take_verdict(const LoopVerdictMessage& message);
  void take_status(const FrontEndStatusMessage& message);
  void take_diagnostics(const diagnostic_msgs::DiagnosticArray& message);
  void show_map(bool always);
  void build_and_publish(const std::shared_ptr<Run>& run, const KeyFramePoses& poses, bool always);
  void take_newest_poses();
  bool save_map(SaveMap::Request& request, SaveMap::Response& response);
  SaveMap::Response save(const std::shared_ptr<Run>& run, const KeyFramePoses& poses,
                         const SaveMap::Request& request);
  std::optional<Eigen::Vector3d> sensor_origin() const;
  std::filesystem::path directory_for(const std::string& asked);

  Config config_;
  NodeContext& context_;
  KeyFrameClient back_end_;
  ScratchFolder scratch_{ros::this_node::getName()};
  std::string run_id_;
  std::size_t runs_ = 0;
  std::shared_ptr<Run> run_;
  DriveView view_;
  std::optional<GeodeticDatum> datum_;
  Worker::ChannelId requests_;
  Worker builder_;
  Worker::ChannelId builds_, saves_;
  ros::Publisher global_map_;
  DriveDisplay display_;
  KeyFrameSubscription key_frames_;
  std::vector<ros::Subscriber> subscribers_;
  ros::CallbackQueue service_queue_;
  ros::ServiceServer service_;
  ros::AsyncSpinner service_spinner_{1, &service_queue_};
};

MapViewerNode::MapViewerNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      back_end_(context.node),
      requests_(context.worker.add_channel("requests", kPublisherQueue)),
      builder_([](const std::string& what, const std::string& problem) {
        ROS_ERROR_STREAM(what << " failed: " << problem);
      }),
      builds_(builder_.add_channel("building the map", 1)),
      saves_(builder_.add_channel("saving the map", kPublisherQueue)),
      global_map_(advertise_map()),
      display_(context, config.node, [this]() -> const DriveView& { return view_; }),
      key_frames_(context, config.node.queue_size,
                  [this](const RunKeyFrame& received) { take_key_frame(received); }) {
  subscribe_all();
  ros::NodeHandle node(context.node);
  node.setCallbackQueue(&service_queue_);
  service_ = node.advertiseService("save_map", &MapViewerNode::save_map, this);
  service_spinner_.start();
}

MapViewerNode::~MapViewerNode() {
  builder_.stop();  // who waits for an answer learns that there will be none
  service_spinner_.stop();
}

/// A map that has no listener is not made, but when somebody comes.
ros::Publisher MapViewerNode::advertise_map() {
  const auto task = [this] {
    if (run_) show_map(true);
  };
  return context_.node.advertise<sensor_msgs::PointCloud2>(
      "global_map", 1, [this, task](const auto&) { context_.worker.post(requests_, task); },
      ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true);
}

void MapViewerNode::subscribe_all() {
  const int capacity = config_.node.queue_size;
  subscribers_ = {
      subscribe<KeyFramePosesMessage>(context_, "key_frame_poses", capacity,
                                      [this](const auto& m) { take_poses(*m); }),
      subscribe<LoopMessage>(context_, "loop", capacity, [this](const auto& m) { take_loop(*m); }),
      subscribe<LoopVerdictMessage>(context_, "loop_verdict", 10 * capacity,
                                    [this](const auto& m) { take_candidate(*m); }),
      subscribe<LoopVerdictMessage>(context_, "graph_verdict", 10 * capacity,
                                    [this](const auto& m) { take_verdict(*m); }),
      subscribe<nav_msgs::Odometry>(context_, "synced_gnss", capacity,
                                    [this](const auto& m) {
                                      if (view_.add_fix(from_message(m->pose.pose).translation))
                                        display_.graph_changed();
                                    }),
      subscribe<FrontEndStatusMessage>(context_, "front_end_status", capacity,
                                       [this](const auto& m) { take_status(*m); }),
      subscribe<diagnostic_msgs::DiagnosticArray>(context_, "/diagnostics", capacity,
                                                  [this](const auto& m) { take_diagnostics(*m); }),
      subscribe<sensor_msgs::NavSatFix>(context_, "gnss_datum", 1, [this](const auto& m) {
        datum_ = GeodeticDatum{m->latitude, m->longitude, m->altitude};
      })};
}

/// What came before the first key frame belongs to its run.
void MapViewerNode::begin_run(const std::string& run_id) {
  if (run_) view_ = {};
  run_id_ = run_id;
  run_ = std::make_shared<Run>(config_.stage, scratch_.path() / std::to_string(++runs_));
}

void MapViewerNode::take_key_frame(const RunKeyFrame& received) {
  if (!run_ || received.run_id != run_id_) begin_run(received.run_id);
  const KeyFrame& key_frame = received.key_frame;
  context_.diagnostics.count_input(key_frame.stamp);
  if (key_frame.cloud) run_->clouds.put(key_frame.index, key_frame.cloud);
  view_.track.add(key_frame);
  context_.diagnostics.set_state(Diagnostics::Level::kOk, "following the drive");
  context_.diagnostics.set("key frames", std::to_string(view_.track.size()));
  display_.graph_changed();
  if (key_frame.index % kKeyFramesPerStep == 0) show_map(false);
}

void MapViewerNode::take_poses(const KeyFramePosesMessage& message) {
  key_frames_.note({message.run_id, message.indices});
  if (!run_ || message.run_id != run_id_) return;
  view_.track.update(from_message(message));
  display_.graph_changed();
  show_map(false);
}

void MapViewerNode::take_loop(const LoopMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  LoopVerdict verdict;
  verdict.from = message.from;
  verdict.to = message.to;
  view_.loops.try_emplace({message.from, message.to}, verdict);
  display_.graph_changed();
}

void MapViewerNode::take_candidate(const LoopVerdictMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  const LoopVerdict verdict = from_message(message);
  if (verdict.verdict == Verdict::kAccepted) {
    view_.candidates.erase({message.from, message.to});
  } else {
    view_.candidates[{message.from, message.to}] = verdict;
  }
  display_.graph_changed();
}

void MapViewerNode::take_verdict(const LoopVerdictMessage& message) {
  if (!run_ || message.run_id != run_id_) return;
  view_.loops[{message.from, message.to}] = from_message(message);
  display_.graph_changed();
}

void MapViewerNode::take_status(const FrontEndStatusMessage& message) {
  view_.newest_scan = ros::WallTime::now();
  if (std::exchange(view_.state, message.state) != message.state) display_.status_changed();
}

/// Why nothing comes is said where people look.
void MapViewerNode::take_diagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  if (!view_.state.empty()) return;
  for (const auto& status : message.status) {
    const bool has_reason = status.level != diagnostic_msgs::DiagnosticStatus::OK &&
                            status.name.find("preprocessing_node") != std::string::npos;
    if (!has_reason || std::exchange(view_.problem, status.message) == status.message) continue;
    display_.status_changed();
  }
}

/// A map that waits to be built is replaced by a newer one.
void MapViewerNode::show_map(bool always) {
  if (global_map_.getNumSubscribers() == 0) return;
  builder_.post(builds_, [this, run = run_, poses = view_.track.poses(), always] {
    build_and_publish(run, poses, always);
  });
}

void MapViewerNode::build_and_publish(const std::shared_ptr<Run>& run, const KeyFramePoses& poses,
                                      bool always) {
  const std::uint64_t before = run->builder.revision();
  run->builder.update(poses);
  if (poses.poses.empty() || (!always && run->builder.revision() == before)) return;
  const PointCloud map = run->builder.build();
  const Stamp stamp = poses.poses.back().stamp;
  global_map_.publish(to_message(map, stamp, config_.node.map_frame));
  context_.diagnostics.count_output(stamp);
  context_.diagnostics.set("points", std::to_string(map.size()));
  context_.diagnostics.set("clouds missing", std::to_string(run->builder.missing_clouds()));
}

/// Poses on their way in a topic may be late: a map that is saved after optimize_map has answered
/// is that of the optimised poses, with all their key frames.
void MapViewerNode::take_newest_poses() {
  const auto state = back_end_.run();
  if (!state) return;
  key_frames_.note(state->indices());
  if (run_ && state->run_id == run_id_) view_.track.update(state->poses);
}

bool MapViewerNode::save_map(SaveMap::Request& request, SaveMap::Response& response) {
  auto answer = std::make_shared<std::promise<SaveMap::Response>>();
  std::future<SaveMap::Response> future = answer->get_future();
  context_.worker.post(requests_, [this, answer, request] {
    take_newest_poses();
    if (!run_) {
      SaveMap::Response nothing;
      nothing.message = "there are no key frames yet; nothing to save";
      return answer->set_value(nothing);
    }
    builder_.post(saves_, [this, answer, request, run = run_, poses = view_.track.poses()] {
      answer->set_value(save(run, poses, request));
    });
  });
  answer.reset();
  try {
    response = future.get();
  } catch (const std::future_error&) {
    response.message = "the map viewer is ending";
  }
  return true;
}

SaveMap::Response MapViewerNode::save(const std::shared_ptr<Run>& run, const KeyFramePoses& poses,
                                      const SaveMap::Request& request) {
  map::ProductOptions options;
  if (!request.formats.empty()) options.formats = request.formats;
  options.frame = config_.node.map_frame;
  options.datum = datum_;
  options.p_base_sensor = sensor_origin();
  options.keep_moving = request.keep_moving;
  SaveMap::Response response;
  try {
    options.crop = map::crop_box(request.crop);
    const std::filesystem::path directory = directory_for(request.directory);
    const map::Products products = map::write_products(
        poses, run->clouds, with_resolution(config_.stage, request.resolution), options, directory);
    for (const auto& file : products.files) response.files.push_back(file.string());
    response.success = true;
    response.message = std::to_string(products.points) + " points of " +
                       std::to_string(poses.poses.size()) + " key frames, written to " +
                       directory.string();
    if (!options.p_base_sensor && !request.keep_moving) {
      response.message += ", with those of moving objects: no session says where the LiDAR is";
    }
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return response;
}

/// None where nobody knows from where the LiDAR saw what it saw.
std::optional<Eigen::Vector3d> MapViewerNode::sensor_origin() const {
  std::string folder;
  if (!context_.node.getParam("session_folder", folder)) return std::nullopt;
  try {
    return session::Session::open(folder, session::Session::Access::kRead).sensor_origin();
  } catch (const FileError&) {
    return std::nullopt;  // the back end is on another machine
  }
}

std::filesystem::path MapViewerNode::directory_for(const std::string& asked) {
  if (!asked.empty()) return path_of_person(asked);
  std::string session;
  if (context_.node.getParam("session_folder", session)) {
    return std::filesystem::path(session) / "map";
  }
  throw InputError("no session is known, as there is no back end; name a directory");
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::MapViewerNode>(argc, argv,
                                                                                       "map");
}
