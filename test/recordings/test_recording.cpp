// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"

#include "recording.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::recordings {
namespace {

/// With tf 1 names of frames began with a slash, or not, as each driver liked.
TEST(Recordings, FindThePlaceOfTheSensorByNamesWithASlash) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "drive.bag").string();
  {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    tf2_msgs::TFMessage frames;
    frames.transforms.resize(1);
    frames.transforms[0].header.frame_id = "/base_link";
    frames.transforms[0].child_frame_id = "lidar";
    frames.transforms[0].transform.translation.z = 2.0;
    frames.transforms[0].transform.rotation.w = 1.0;
    bag.write("/tf_static", ros::Time(100), frames);
    PointCloud cloud;
    cloud.points.push_back({1.0F, 2.0F, 3.0F, 0.5F});
    bag.write("/points", ros::Time(100),
              ros_border::to_message(cloud, from_seconds(100.0), "/lidar"));
  }
  const Recording recording = open_recording(path, "", {});
  EXPECT_EQ(recording.size, 1U);
  EXPECT_EQ(recording.T_base_sensor.translation.z(), 2.0);
}

}  // namespace
}  // namespace lidar_mapping::recordings
