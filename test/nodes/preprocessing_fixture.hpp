// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "listener.hpp"
#include "node_process.hpp"
#include "yard.hpp"

namespace lidar_mapping::test {

/// A preprocessing_node whose scans, IMU and fixes the test sends.
class PreprocessingNode : public testing::Test {
 protected:
  PreprocessingNode()
      : node_(start()),
        clouds_(connected_publisher<sensor_msgs::PointCloud2>("points")),
        imu_(connected_publisher<sensor_msgs::Imu>("imu")),
        gnss_(connected_publisher<sensor_msgs::NavSatFix>("gnss")) {
    EXPECT_TRUE(wait_until([&] { return connected(); }));
  }

  static std::unique_ptr<NodeProcess> start() {
    return std::make_unique<NodeProcess>("preprocessing_node",
                                         std::vector<std::string>{"_max_latency:=2.0"});
  }
  bool connected() const {
    for (const char* topic : {"points", "imu", "gnss", "tf_static", "synced_cloud", "synced_imu",
                              "synced_gnss", "gnss_datum"}) {
      if (!is_connected(topic)) return false;
    }
    return true;
  }
  /// Scans with an IMU and a fix before and after each.
  void drive(int begin, int end) {
    for (int step = begin; step < end; ++step) {
      send_samples(stamp_of(step) - kPeriod / 2);
      send_cloud(step);
    }
    send_samples(stamp_of(end - 1) + kPeriod / 2);
  }

  void send_cloud(int step) {
    clouds_.publish(
        ros_border::to_message(yard_seen_from(straight(step), 7U), stamp_of(step), "lidar"));
  }
  void send_samples(Stamp stamp) {
    sensor_msgs::Imu imu;
    imu.header.stamp = ros_border::to_ros(stamp);
    imu.header.frame_id = "/lidar";  // as tf 1 wrote it
    imu.orientation.w = 1.0;
    imu.linear_acceleration.z = 9.81;
    imu_.publish(imu);
    sensor_msgs::NavSatFix fix;
    fix.header = imu.header;
    fix.latitude = latitude_;
    fix.longitude = 8.4;
    gnss_.publish(fix);
  }
  void send_transform() {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "lidar";
    transform.transform.translation.z = 2.0;
    transform.transform.rotation.w = 1.0;
    transforms_.sendTransform(transform);
  }

  double latitude_ = 49.0;
  std::unique_ptr<NodeProcess> node_;
  ros::Publisher clouds_, imu_, gnss_;
  tf2_ros::StaticTransformBroadcaster transforms_;
  Listener<sensor_msgs::PointCloud2> synced_{"synced_cloud"};
  Listener<sensor_msgs::Imu> synced_imu_{"synced_imu"};
  Listener<nav_msgs::Odometry> synced_gnss_{"synced_gnss"};
  Listener<sensor_msgs::NavSatFix> datum_{"gnss_datum"};
};

}  // namespace lidar_mapping::test
