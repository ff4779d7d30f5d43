// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/transform_odometry.hpp"

#include "near.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kBegin = 1'000'000'000'000;
constexpr Stamp kPeriod = 20'000'000;

tf2_msgs::TFMessage message_of(Stamp stamp, const Pose& T_parent_child, const std::string& parent,
                               const std::string& child) {
  tf2_msgs::TFMessage message;
  message.transforms = {stamped_transform(T_parent_child, stamp, parent, child)};
  return message;
}

/// 5 m/s round a circle of 10 m radius.
Pose on_circle(double seconds) {
  const double turn = 0.5 * seconds;
  return {exp_so3({0.0, 0.0, turn}), {10.0 * std::sin(turn), 10.0 * (1.0 - std::cos(turn)), 0.0}};
}

TEST(TransformOdometry, GivesTheVelocityBetweenTwoPosesWhicheverFrameIsTheParent) {
  for (const bool upright : {true, false}) {
    TransformOdometry odometry("wheels", "/base_link");
    for (int i = 0; i < 10; ++i) {
      const Pose T_odom_base = on_circle(0.02 * i);
      const auto message =
          upright ? message_of(kBegin + i * kPeriod, T_odom_base, "wheels", "base_link")
                  : message_of(kBegin + i * kPeriod, T_odom_base.inverse(), "/base_link", "wheels");
      const std::vector<VelocitySample> velocities = odometry.add(message);
      ASSERT_EQ(velocities.size(), i == 0 ? 0U : 1U);
      if (i == 0) continue;
      EXPECT_EQ(velocities[0].stamp, kBegin + i * kPeriod - kPeriod / 2);
      EXPECT_TRUE(test::near(velocities[0].linear, Eigen::Vector3d(5.0, 0.0, 0.0), 1e-3));
      EXPECT_TRUE(test::near(velocities[0].angular, Eigen::Vector3d(0.0, 0.0, 0.5), 1e-9));
    }
  }
}

TEST(TransformOdometry, IgnoresTransformsWithoutMotion) {
  TransformOdometry odometry("wheels", "base_link");
  const auto add = [&](double seconds, const std::string& parent = "wheels") {
    return odometry.add(
        message_of(kBegin + from_seconds(seconds), on_circle(seconds), parent, "base_link"));
  };
  EXPECT_TRUE(add(0.0).empty());
  EXPECT_TRUE(add(0.02, "odom").empty()) << "another odometry";
  EXPECT_EQ(add(0.04).size(), 1U);
  EXPECT_TRUE(add(0.04).empty()) << "again";
  EXPECT_TRUE(add(0.02).empty()) << "back";
  EXPECT_TRUE(add(2.0).empty()) << "after a gap";
  EXPECT_EQ(add(2.02).size(), 1U);
  auto broken = message_of(kBegin + from_seconds(2.04), on_circle(2.04), "wheels", "base_link");
  broken.transforms[0].transform.rotation.w = 5.0;
  EXPECT_TRUE(odometry.add(broken).empty());
  EXPECT_EQ(add(2.06).size(), 1U);
}

TEST(TransformOdometry, NeedsAFrameOfItsOwn) {
  EXPECT_THROW(TransformOdometry("", "base_link"), ConfigError);
  EXPECT_THROW(TransformOdometry("/base_link", "base_link"), ConfigError);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
