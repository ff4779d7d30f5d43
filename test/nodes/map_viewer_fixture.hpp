// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>

#include "listener.hpp"
#include "round_drive.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// A back end that has some key frames.
class MapViewerNode : public testing::Test {
 protected:
  MapViewerNode() {
    const boost::function<bool(GetKeyFrames::Request&, GetKeyFrames::Response&)> answer =
        [this](GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
          return serve(request, response);
        };
    service_ = ros::NodeHandle().advertiseService("get_key_frames", answer);
  }

  bool serve(const GetKeyFrames::Request& request, GetKeyFrames::Response& response) {
    response.poses = poses_;
    response.poses.run_id = "run";
    response.poses.whole = true;
    for (const KeyFrameMessage& message : stored_) {
      const bool wanted = request.indices.empty() ||
                          std::count(request.indices.begin(), request.indices.end(), message.index);
      if (wanted) response.key_frames.push_back(message);
    }
    response.gnss = fixes_;
    response.antennas.resize(fixes_.size());
    response.floors = floors_;
    return true;
  }

  void store(int count) {
    for (int i = 0; i < count; ++i) stored_.push_back(round_message(i));
  }
  /// Waits until the node shows a path of so many key frames.
  static bool shows(std::size_t count) {
    Listener<nav_msgs::Path> path("optimized_path");
    return wait_until(
        [&] { return !path.messages.empty() && path.messages.back().poses.size() == count; });
  }

  static KeyFramePosesMessage corrected(int count, std::uint32_t revision) {
    KeyFramePoses poses;
    poses.revision = revision;
    for (int i = 0; i < count; ++i) {
      poses.poses.push_back(
          {static_cast<KeyFrameIndex>(i), round_key_frame(i).stamp, true_pose(i)});
    }
    return ros_border::to_message(poses, "run", "map");
  }

  /// Calls the service while the services and topics of this process go on.
  SaveMap::Response save(const std::filesystem::path& directory,
                         std::vector<std::string> formats = {}, bool keep_moving = false,
                         double resolution = 0.0, std::vector<double> crop = {}) {
    SaveMap request;
    request.request.directory = directory.string();
    request.request.formats = std::move(formats);
    request.request.keep_moving = keep_moving;
    request.request.resolution = resolution;
    request.request.crop = std::move(crop);
    return save(request);
  }
  static SaveMap::Response save(SaveMap& call) {
    ros::AsyncSpinner spinner(1);
    spinner.start();
    ros::service::waitForService("save_map", ros::Duration(20.0));
    ros::service::call("save_map", call);
    return call.response;
  }

  TemporaryFolder folder_;
  std::vector<KeyFrameMessage> stored_;
  KeyFramePosesMessage poses_;
  std::vector<nav_msgs::Odometry> fixes_;
  std::vector<FloorMessage> floors_;
  ros::ServiceServer service_;
};

}  // namespace lidar_mapping::test
