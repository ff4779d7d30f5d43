// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "localization/matched_cloud.hpp"

namespace lidar_mapping::ros_border {
namespace {

using localization::kNotInMap;

TEST(MatchedCloud, LiesInTheMapWithAFieldForTheAgreement) {
  Pose T_map_base;
  T_map_base.translation = {100.0, 20.0, 3.0};
  T_map_base.rotation = Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ());
  const auto message = matched_cloud({{{1.0F, 2.0F, 0.5F}, 0.75F}, {{4.0F, 0.0F, 0.0F}, kNotInMap}},
                                     T_map_base, 1'500'000'000'000'000'123, "map");
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(from_ros(message.header.stamp), 1'500'000'000'000'000'123);
  ASSERT_EQ(message.width * message.height, 2U);
  EXPECT_EQ(message.point_step, 16U);
  sensor_msgs::PointCloud2ConstIterator<float> x(message, "x"), y(message, "y"), z(message, "z"),
      agreement(message, "agreement");
  EXPECT_NEAR(*x, 98.0F, 1e-4F);  // a quarter turn to the left: x = 100 - 2, y = 20 + 1
  EXPECT_NEAR(*y, 21.0F, 1e-4F);
  EXPECT_NEAR(*z, 3.5F, 1e-4F);
  EXPECT_EQ(*agreement, 0.75F);
  EXPECT_EQ(*++agreement, kNotInMap);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
