// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>

#include "lidar_mapping/common/trajectory.hpp"

#include "cloud_forms.hpp"
#include "commands.hpp"
#include "rewritten_bag.hpp"

namespace lidar_mapping::test {

constexpr char kTopic[] = "/points";

/// Writes a message that is made of each cloud.
template <typename Make>
WriteCloud with(const Make& make) {
  return [make](rosbag::Bag& to, const ros::Time& recorded, const sensor_msgs::PointCloud2& cloud) {
    to.write(kTopic, recorded, make(cloud));
  };
}

/// A drive in other forms, and what the commands make of it.
class InputForms : public Commands {
 protected:
  /// A drive of a VLP-16 that was simulated once for all tests.
  static std::string drive() {
    static const std::string bag = [] {
      const std::string path = root() / "drive.bag";
      EXPECT_EQ(run("simulate_drive", {path, "--lidar", "vlp16", "--duration", "8"}), 0);
      return path;
    }();
    return bag;
  }

  std::string rewritten(const std::string& name, const WriteMessage& write) const {
    const std::string path = folder_.path() / (name + ".bag");
    rewrite_bag(drive(), path, write);
    return path;
  }
  std::string written(const std::string& name, const WriteCloud& write) const {
    return rewritten(name, for_clouds(write));
  }
  /// The odometry that map_bag makes of a recording.
  Trajectory mapped(const std::string& input, const Words& more = {}) const {
    static int sessions = 0;
    const std::string session = folder_.path() / ("session_" + std::to_string(++sessions));
    const Words words = {input, "-o", session, "--no-map", "--allow-doubt"};
    EXPECT_EQ(run("map_bag", joined(words, more)), 0);
    return read_trajectory(session + "/trajectory/laser_odom_scans.tum");
  }
  /// What check_bag says of a recording, and its exit status.
  static Ending checked(const std::string& input, const Words& more = {}) {
    return run("check_bag", joined({input}, more));
  }

  static void expect_equal_poses(const Trajectory& trajectory, const Trajectory& plain) {
    ASSERT_EQ(trajectory.poses.size(), plain.poses.size());
    ASSERT_GT(plain.poses.size(), 40U);
    double largest = 0.0, way = 0.0;
    for (std::size_t i = 0; i < plain.poses.size(); ++i) {
      ASSERT_EQ(trajectory.poses[i].stamp, plain.poses[i].stamp);
      const Pose& pose = plain.poses[i].pose;
      largest = std::max(largest, (trajectory.poses[i].pose.translation - pose.translation).norm());
      way = std::max(way, pose.translation.norm());
    }
    EXPECT_LT(largest, 1e-3);  // m
    EXPECT_GT(way, 10.0);
    RecordProperty("largest_difference_um", static_cast<int>(1e6 * largest));
    std::printf("largest difference of the positions: %.1f um\n", 1e6 * largest);
  }
  void expect_poses_of_the_drive(const std::string& name, const WriteCloud& write) const {
    expect_equal_poses(mapped(written(name, write)), plain_poses());
  }
  static void expect_said(const Ending& ending, const std::string& words, int status) {
    EXPECT_TRUE(holds(ending.said, words));
    EXPECT_EQ(ending, status);
  }

  /// The odometry of the drive with its clouds as they are, made once for all tests.
  Trajectory plain_poses() const {
    static const Trajectory poses = mapped(plain_bag());
    return poses;
  }
  /// The drive with its clouds as they are.
  std::string plain_bag() const {
    return written("plain", with([](const sensor_msgs::PointCloud2& cloud) { return cloud; }));
  }
};

}  // namespace lidar_mapping::test
