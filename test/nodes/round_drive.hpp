// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"

namespace lidar_mapping::test {

/// A drive round a circle, 2 m between key frames, whose odometry turns a little too much; the last
/// key frame is where the first was.
constexpr int kRound = 40;

inline Pose true_pose(int index) {
  const double angle = 2.0 * M_PI * index / (kRound - 1);
  const double radius = 2.0 * (kRound - 1) / (2.0 * M_PI);
  return {exp_so3({0.0, 0.0, angle}),
          {radius * std::sin(angle), radius * (1.0 - std::cos(angle)), 0.0}};
}

inline KeyFrame round_key_frame(int index) {
  KeyFrame key_frame;
  key_frame.index = static_cast<KeyFrameIndex>(index);
  key_frame.stamp = 1317384506123456789 + index * 400000000LL;
  key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
  const Pose drift{exp_so3({0.0, 0.0, 0.001}), Eigen::Vector3d::Zero()};
  for (int i = 1; i <= index; ++i) {
    key_frame.T_odom_base =
        key_frame.T_odom_base * true_pose(i - 1).inverse() * true_pose(i) * drift;
  }
  auto cloud = std::make_shared<PointCloud>();
  for (int i = 0; i < 50; ++i)
    cloud->points.push_back({0.3F * static_cast<float>(i), 5.0F, 1.0F, 9.0F});
  key_frame.cloud = cloud;
  return key_frame;
}

inline KeyFrameMessage round_message(int index, const std::string& run_id = "run") {
  return ros_border::to_message(round_key_frame(index), run_id, "base_link");
}

inline LoopMessage round_loop(KeyFrameIndex from = 0, KeyFrameIndex to = kRound - 1,
                              const std::string& run_id = "run") {
  Loop loop;
  loop.from = from;
  loop.to = to;
  loop.stamp = round_key_frame(static_cast<int>(to)).stamp;
  loop.T_from_to = true_pose(static_cast<int>(from)).inverse() * true_pose(static_cast<int>(to));
  loop.covariance = diagonal_covariance(0.02, 0.002);
  loop.overlap = 0.9;
  return ros_border::to_message(loop, run_id, "base_link");
}

}  // namespace lidar_mapping::test
