// SPDX-License-Identifier: BSD-3-Clause
#include <set>
#include <tuple>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "back_end_node.hpp"
#include "worker_tasks.hpp"

// The services optimize_map and get_key_frames.
namespace lidar_mapping::ros_border {

/// Services wait for the worker, so they run in threads of their own.
void BackEndNode::advertise_services() {
  ros::NodeHandle node(context_.node);
  node.setCallbackQueue(&service_queue_);
  services_ = {node.advertiseService("optimize_map", &BackEndNode::optimize_map, this),
               node.advertiseService("get_key_frames", &BackEndNode::get_key_frames, this),
               node.advertiseService("dump_graph", &BackEndNode::dump_graph, this),
               node.advertiseService("load_graph", &BackEndNode::load_graph, this)};
  service_spinner_.start();
}

bool BackEndNode::optimize_map(OptimizeMap::Request&, OptimizeMap::Response& response) {
  return answered(response, [this] {
    return result_in(context_.worker, requests_, [this] { return request_optimization(); }).get();
  });
}

/// Runs in the worker. The answer follows when the graph is solved.
std::future<OptimizeMap::Response> BackEndNode::request_optimization() {
  if (!run_ && !unstored_.empty()) throw InputError(unstored_.text() + "; nothing to optimise");
  if (!run_) throw InputError("there are no key frames yet; nothing to optimise");
  finalize();
  SolverQueue::Answer promise;
  std::future<OptimizeMap::Response> future = promise.get_future();
  solver_.add_request(std::move(promise));
  if (!solver_.is_solving()) start_solving(true);
  return future;
}

bool BackEndNode::get_key_frames(GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
  std::shared_ptr<Run> run;  // keeps the store of the clouds while they are read
  try {
    std::tie(response, run) =
        result_in(context_.worker, requests_, [this, wanted = request.indices] {
          return std::make_pair(key_frames_without_clouds(wanted), run_);
        });
  } catch (const std::future_error&) {
    return false;
  }
  if (!request.clouds || !run) return true;
  for (KeyFrameMessage& message : response.key_frames) {
    const PointCloudPtr cloud = run->session().clouds().cloud(message.index);
    if (!cloud) continue;
    message.cloud = to_message(*cloud, from_ros(message.header.stamp), config_.node.base_frame);
  }
  return true;
}

GetKeyFrames::Response BackEndNode::key_frames_without_clouds(
    const std::vector<KeyFrameIndex>& wanted) {
  GetKeyFrames::Response response;
  if (!run_) return response;
  const auto give = [&, p_base_lidar = run_->session().sensor_origin()](const KeyFrame& key_frame) {
    response.key_frames.push_back(
        to_message(key_frame, run_id_, config_.node.base_frame, p_base_lidar));
  };
  if (wanted.empty()) {
    for (const KeyFrame& key_frame : run_->session().key_frames()) give(key_frame);
  }
  for (const KeyFrameIndex index : std::set<KeyFrameIndex>(wanted.begin(), wanted.end())) {
    if (const auto key_frame = run_->session().key_frame(index)) give(*key_frame);
  }
  response.poses = to_message(run_->poses(), run_id_, config_.node.map_frame);
  if (wanted.empty()) add_loop_closing_state(response);
  return response;
}

void BackEndNode::add_loop_closing_state(GetKeyFrames::Response& response) const {
  const session::Session& session = run_->session();
  for (const Loop& loop : session.loops()) {
    response.loops.push_back(to_message(loop, run_id_, config_.node.base_frame));
  }
  std::set<Stamp> stamps;
  for (const KeyFrame& key_frame : session.key_frames()) stamps.insert(key_frame.stamp);
  for (const GnssPosition& position : session.gnss()) {
    if (stamps.count(position.stamp) == 0) continue;
    response.gnss.push_back(to_message(position, config_.node.map_frame, ""));
    response.antennas.push_back(to_message(position.p_base_antenna));
  }
  for (const Floor& floor : session.floors()) {
    if (!floor.found || stamps.count(floor.stamp) == 0) continue;
    response.floors.push_back(to_message(floor, config_.node.base_frame));
  }
  response.searched = run_->searched_key_frames();
}

}  // namespace lidar_mapping::ros_border
