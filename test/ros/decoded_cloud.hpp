// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include "cloud_builder.hpp"

/// Clouds of a turn of the sensor, and what has to become of them.
namespace lidar_mapping::test {

constexpr std::uint32_t kCount = 1000;  // points of a turn
constexpr double kPeriod = 0.1;         // s, of a turn

/// Where in the turn a point is, 0 to 1.
inline double fraction(std::size_t i) { return static_cast<double>(i) / (kCount - 1); }

/// When a point was measured, in s from the beginning of the turn.
inline double turn_time(std::size_t i) { return kPeriod * fraction(i); }

/// The points of put_positions() and, for each, `time(i)`.
template <typename Time>
void expect_points(const ros_border::DecodedCloud& decoded, const Time& time, double tolerance) {
  const PointCloud& cloud = decoded.scan.cloud;
  ASSERT_EQ(cloud.size(), kCount);
  ASSERT_EQ(cloud.times.size(), kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(cloud.points[i].position(),
              (Eigen::Vector3f(1, 2, 3) * static_cast<float>(i)).eval());
    EXPECT_NEAR(cloud.times[i], time(i), tolerance);
  }
}

/// x y z intensity ring timestamp as Hesai and RoboSense have them.
inline sensor_msgs::PointCloud2 absolute_cloud(double unit, const ros::Time& stamp, double first) {
  auto message = xyz_cloud({{"intensity", sensor_msgs::PointField::FLOAT32, 16},
                            {"timestamp", sensor_msgs::PointField::FLOAT64, 24},
                            {"ring", sensor_msgs::PointField::UINT16, 32}},
                           48, kCount, stamp);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double since_second = 1e-9 * stamp.nsec + first + kPeriod * fraction(i);
    put(message, i, 24, (stamp.sec + since_second) / unit);
  }
  return message;
}

/// x y z intensity time, with points of `step` bytes.
inline sensor_msgs::PointCloud2 plain_cloud(std::uint32_t step) {
  auto message = xyz_cloud({{"intensity", sensor_msgs::PointField::FLOAT32, step - 8},
                            {"time", sensor_msgs::PointField::FLOAT32, step - 4}},
                           step, kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, step - 8, static_cast<float>(i));
    put(message, i, step - 4, static_cast<float>(kPeriod * fraction(i)));
  }
  return message;
}

}  // namespace lidar_mapping::test
