// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping {
namespace {

TEST(HorizontalStddev, IsTheRootMeanSquareOfEastAndNorth) {
  Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 49.0, 1e8).asDiagonal();
  covariance(0, 1) = covariance(1, 0) = 6.0;
  EXPECT_DOUBLE_EQ(horizontal_stddev(covariance), 5.0) << "whatever the height and the directions";
}

}  // namespace
}  // namespace lidar_mapping
