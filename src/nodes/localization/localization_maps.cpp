// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/map/display_map.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"

#include "localization_node.hpp"
#include "worker_tasks.hpp"

// Maps: reading them, and the services relocalize and load_map.
namespace lidar_mapping::ros_border {

/// Services wait for a map or for the worker, so they run in a thread of their own.
void LocalizationNode::advertise_services() {
  ros::NodeHandle node(context_.node);
  node.setCallbackQueue(&service_queue_);
  services_ = {node.advertiseService("relocalize", &LocalizationNode::relocalize, this),
               node.advertiseService("load_map", &LocalizationNode::load_map, this),
               node.advertiseService("save_session", &LocalizationNode::save_session, this)};
  service_spinner_.start();
}

/// A map that cannot be read leaves the node waiting for load_map.
void LocalizationNode::load_first(const std::string& folder) {
  try {
    load(folder);
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
    context_.worker.post(requests_, [this, reason = std::string(error.what())] {
      loading_ = reason;
      context_.diagnostics.set_state(Diagnostics::Level::kError, reason);
    });
  }
}

/// Reads a map in the loader's thread, and gives it to the worker. The map before stays in use
/// until then, also if this one cannot be read. Throws Error.
std::string LocalizationNode::load(const std::string& folder) {
  auto active_map = std::make_shared<ActiveMap>(expanded_path(folder), config_.stage);
  begin_recording(*active_map);
  const double resolution = map::display_resolution(active_map->map.index().gaussians());
  const auto cloud = std::make_shared<PointCloud>(active_map->map.cloud(resolution));
  const std::string summary =
      "the map " + active_map->map.directory().string() + ": " + active_map->map.size_text();
  context_.worker.post(requests_, [this, active_map, cloud] { use(active_map, *cloud); });
  ROS_INFO_STREAM(summary);
  return summary;
}

void LocalizationNode::use(std::shared_ptr<ActiveMap> active_map, const PointCloud& cloud) {
  active_map_ = std::move(active_map);
  path_.poses.clear();
  context_.diagnostics.set("map", active_map_->map.directory().string());
  context_.diagnostics.set_state(Diagnostics::Level::kWarning, "waiting for scans");
  map_cloud_.publish(to_message(cloud, 0, config_.node.map_frame));
}

bool LocalizationNode::relocalize(Relocalize::Request&, Relocalize::Response& response) {
  return answered(response, [this] {
    return result_in(context_.worker, requests_, [this] {
      if (!active_map_) throw InputError(loading_);
      withdraw_place();
      active_map_->localizer.restart();
      Relocalize::Response given;
      given.success = true;
      given.message = "the place is searched for in the whole map";
      return given;
    });
  });
}

bool LocalizationNode::load_map(LoadMap::Request& request, LoadMap::Response& response) {
  return answered(response, [&] {
    return result_in(loader_, loads_, [this, folder = request.path] {
      LoadMap::Response given;
      given.message = load(folder);
      given.success = true;
      return given;
    });
  });
}

}  // namespace lidar_mapping::ros_border
