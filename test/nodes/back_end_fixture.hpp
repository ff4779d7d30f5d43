// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "listener.hpp"
#include "node_process.hpp"
#include "round_drive.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// A back end with a folder for its sessions, and publishers of what it receives.
class BackEndNode : public testing::Test {
 protected:
  std::unique_ptr<NodeProcess> start(std::vector<std::string> arguments = {}) {
    arguments.push_back("_session_directory:=" + (folder_.path() / "sessions").string());
    auto node = std::make_unique<NodeProcess>("back_end_node", arguments);
    EXPECT_TRUE(wait_until([&] {
      return is_connected("key_frame") && is_connected("loop") && poses_.connected() &&
             ros::service::exists("optimize_map", false);
    })) << node->output();
    return node;
  }

  void publish(int begin, int end, const std::string& run_id = "run") {
    for (int i = begin; i < end; ++i) key_frames_.publish(round_message(i, run_id));
  }

  GetKeyFrames::Response known(bool clouds = false, std::vector<std::uint32_t> indices = {}) {
    GetKeyFrames request;
    request.request.clouds = clouds;
    request.request.indices = std::move(indices);
    ros::service::call("get_key_frames", request);
    return request.response;
  }
  bool wait_for_key_frames(std::size_t count) {
    return wait_until([&] { return known().key_frames.size() == count; });
  }
  OptimizeMap::Response optimize() {
    OptimizeMap request;
    ros::service::call("optimize_map", request);
    return request.response;
  }
  DumpGraph::Response dump(const std::filesystem::path& destination) {
    DumpGraph call;
    call.request.destination = destination.string();
    ros::service::call("dump_graph", call);
    return call.response;
  }
  LoadGraph::Response load(const std::filesystem::path& path) {
    LoadGraph call;
    call.request.path = path.string();
    ros::service::call("load_graph", call);
    return call.response;
  }
  std::vector<std::filesystem::path> sessions() const {
    std::vector<std::filesystem::path> result;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "sessions")) {
      if (!entry.is_symlink()) result.push_back(entry.path());
    }
    return result;
  }

  TemporaryFolder folder_;
  ros::Publisher key_frames_ = ros::NodeHandle().advertise<KeyFrameMessage>("key_frame", 1000);
  ros::Publisher loops_ = ros::NodeHandle().advertise<LoopMessage>("loop", 1000);
  Listener<KeyFramePosesMessage> poses_{"key_frame_poses"};
};

}  // namespace lidar_mapping::test
