// SPDX-License-Identifier: BSD-3-Clause
#include <limits>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/recorded_frames.hpp"

#include "near.hpp"

namespace lidar_mapping::ros_border {
namespace {

tf2_msgs::TFMessage height_of(const std::string& frame, const ros::Time& stamp, double z) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.stamp = stamp;
  message.transforms[0].header.frame_id = "base_link";
  message.transforms[0].child_frame_id = frame;
  message.transforms[0].transform.translation.z = z;
  message.transforms[0].transform.rotation.w = 1.0;
  return message;
}

/// As damaged recordings have them: the last time that a stamp can hold.
TEST(RecordedFrames, AStampWithoutRoomBehindItIsLeftOut) {
  RecordedFrames frames("base_link");
  frames.add(height_of("lidar", ros::Time(100), 2.0), false);
  const ros::Time last(std::numeric_limits<std::uint32_t>::max(), 999'999'999);
  EXPECT_NO_THROW(frames.add(height_of("lidar", last, 5.0), false));
  ASSERT_TRUE(frames.T_base("lidar"));
  EXPECT_EQ(frames.T_base("lidar")->translation.z(), 2.0);
}

TEST(RecordedFrames, ATransformThatComesTwiceIsTakenOnceWithoutAWord) {
  RecordedFrames frames("base_link");
  testing::internal::CaptureStderr();
  for (const double stamp : {100.0, 100.0, 100.1}) {
    frames.add(height_of("lidar", ros::Time(stamp), stamp), false);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  ASSERT_TRUE(frames.T_base("lidar"));
  EXPECT_EQ(frames.T_base("lidar")->translation.z(), 100.1);
}

/// A turn to the left by a quarter, as a person types it.
TEST(RecordedFrames, ARoundedRotationIsTaken) {
  RecordedFrames frames("base_link");
  tf2_msgs::TFMessage message = height_of("lidar", ros::Time(100), 2.0);
  message.transforms[0].transform.rotation.z = 0.7;
  message.transforms[0].transform.rotation.w = 0.7;
  frames.add(message, true);
  ASSERT_TRUE(frames.T_base("lidar"));
  const Eigen::Vector3d ahead = frames.T_base("lidar")->rotation * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(test::near(ahead, Eigen::Vector3d::UnitY(), 1e-9));
  EXPECT_EQ(frames.problem(), "");
}

TEST(RecordedFrames, ATransformThatIsNoneIsLeftOutAndNamed) {
  RecordedFrames frames("base_link");
  tf2_msgs::TFMessage message = height_of("lidar", ros::Time(100), 2.0);
  message.transforms[0].transform.rotation.w = 0.0;
  frames.add(message, true);
  EXPECT_FALSE(frames.T_base("lidar"));
  EXPECT_EQ(frames.problem(),
            "the transform from 'base_link' to 'lidar' has the quaternion (0, 0, 0, 0), whose "
            "length is not 1");
  const double none = std::numeric_limits<double>::quiet_NaN();
  RecordedFrames others("base_link");
  others.add(height_of("lidar", ros::Time(100), none), true);
  EXPECT_FALSE(others.T_base("lidar"));
  EXPECT_EQ(others.problem(),
            "the transform from 'base_link' to 'lidar' has a translation that is not finite");
}

}  // namespace
}  // namespace lidar_mapping::ros_border
