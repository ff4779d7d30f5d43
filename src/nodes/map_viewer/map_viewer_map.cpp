// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/pipeline/session_marks.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/session/map_datum.hpp"

#include "map_viewer/map_order.hpp"
#include "map_viewer_node.hpp"
#include "worker_tasks.hpp"

// The map: its display, and the service save_map that writes it to disk.
namespace lidar_mapping::ros_border {

namespace {

/// `stage`, with another resolution unless that is 0.
map::MapConfig with_resolution(const map::MapConfig& stage, double resolution) {
  if (resolution == 0.0) return stage;
  return config::load<map::MapConfig>(
      {config::parse_yaml(config::to_yaml(stage), "map"),
       {"save_map", {config::Value::Map{{"resolution", {resolution}}}}}});
}

}  // namespace

/// The map is only built while there are subscribers; a new subscriber triggers it.
ros::Publisher MapViewerNode::advertise_map() {
  const auto show = [this] {
    if (run_) show_map(true);
  };
  return advertise<sensor_msgs::PointCloud2>(context_, "global_map", 1, requests_, show, true);
}

/// For key frames that are new, and for poses that moved too little to be shown at once.
void MapViewerNode::refresh_at_intervals() {
  if (config_.map_cloud_update_interval == 0.0) return;
  refresh_timer_ =
      do_at_intervals(context_, "map refresh", config_.map_cloud_update_interval, [this] {
        if (run_ && map_outdated_) show_map(false);
      });
}

/// A request that still waits in the queue is replaced by this newer one.
void MapViewerNode::show_map(bool always) {
  if (global_map_.getNumSubscribers() == 0) return;
  map_outdated_ = false;
  builder_.post(builds_, [this, run = run_, poses = view_.track.poses(), always] {
    build_and_publish(run, poses, always);
  });
}

void MapViewerNode::build_and_publish(const std::shared_ptr<Run>& run, const KeyFramePoses& poses,
                                      bool always) {
  const bool changes = run->display.update(poses);
  if (poses.poses.empty() || (!always && !changes)) return;
  const PointCloud map = run->display.build();
  const Stamp stamp = poses.poses.back().stamp;
  global_map_.publish(to_message(map, stamp, config_.node.map_frame));
  context_.diagnostics.count_output(stamp);
  context_.diagnostics.set("points", map.size());
  context_.diagnostics.set("resolution, m", run->display.resolution());
  context_.diagnostics.set("clouds missing", run->display.missing_clouds());
}

/// Poses on the topic may arrive late, so the newest ones are fetched by the service: a map saved
/// after optimize_map then has the optimised poses with all their key frames.
void MapViewerNode::fetch_newest_poses() {
  const auto state = back_end_.run();
  if (!state) return;
  key_frames_.note(state->indices());
  poses_.push({state->run_id, state->poses});
  if (run_ && state->run_id == run_id_) view_.track.update(state->poses);
}

bool MapViewerNode::save_map(SaveMap::Request& request, SaveMap::Response& response) {
  return answered(response, [&] {
    const MapInput input = result_in(context_.worker, requests_, [this] {
      fetch_newest_poses();
      if (!run_) throw InputError("there are no key frames yet; nothing to save");
      return MapInput{run_, run_id_, view_.track.poses(), session_frame_.datum()};
    });
    return result_in(builder_, saves_, [this, input, request] { return save(input, request); });
  });
}

SaveMap::Response MapViewerNode::save(const MapInput& input, const SaveMap::Request& request) {
  MapOrder order = map_order(request);
  order.options.datum = input.datum;
  complete(order.options, input);
  if (order.directory.empty()) order.directory = session_map(input.run_id);
  const map::Products products = map::write_products(
      input.poses, input.run->clouds, with_resolution(config_.stage, request.resolution),
      order.options, order.directory);
  SaveMap::Response response;
  for (const auto& file : products.files) response.files.push_back(file.string());
  response.success = true;
  // Some products, such as GeoJSON, need no points.
  if (products.points > 0) response.message = std::to_string(products.points) + " points of ";
  response.message += std::to_string(input.poses.poses.size()) + " key frames, written to " +
                      order.place().string();
  if (!order.options.p_base_sensor && !request.keep_moving) {
    response.message +=
        ", including those of moving objects, because no session contains the position of the "
        "LiDAR";
  }
  return response;
}

/// Adds sensor origin, datum and marks from the session. Its datum has priority over that of this
/// node, because a resumed session keeps the datum of its first drive, and because it knows whether
/// the map was turned to East-North-Up.
void MapViewerNode::complete(map::ProductOptions& options, const MapInput& input) const {
  options.frame = config_.node.map_frame;
  try {
    const auto session = session_of(input.run_id);
    if (!session) return;
    options.p_base_sensor = session->sensor_origin();
    if (session->datum() || !session->poses_in_enu().value_or(true)) {
      options.datum = session::map_datum(*session);
    }
    options.marks = [folder = session->directory(), &poses = input.poses] {
      return pipeline::session_marks(
          session::Session::open(folder, session::Session::Access::kRead), poses);
    };
  } catch (const Error& error) {
    // As where the back end runs on another machine.
    ROS_WARN_STREAM("the map is saved without what the session knows: " << error.what());
  }
}

std::filesystem::path MapViewerNode::session_map(const std::string& run_id) const {
  if (const auto session = session_of(run_id)) return session->directory() / "map";
  throw InputError("the back end has no session, or there is none; name a directory");
}

/// The session into which the back end writes the run; empty if there is none. Throws FileError if
/// it cannot be read, and InputError if it is that of another run.
std::optional<session::Session> MapViewerNode::session_of(const std::string& run_id) const {
  std::string folder;
  if (!context_.node.getParam(kRunSession, folder)) return std::nullopt;
  auto session = session::Session::open(folder, session::Session::Access::kRead);
  if (session.run_id() == run_id) return session;
  throw InputError("the session " + folder + " is that of run '" + session.run_id() +
                   "', not of run '" + run_id +
                   "': the map can be saved only without it, to a directory that is named");
}

}  // namespace lidar_mapping::ros_border
