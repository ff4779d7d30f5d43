// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"

#include "listener.hpp"
#include "node_process.hpp"
#include "yard.hpp"

namespace lidar_mapping::test {
namespace {

using ros_border::from_ros;

constexpr double kHeight = 1.5;  // m of the vehicle's origin above the floor

/// A level floor around the vehicle, a point each 20 cm.
PointCloud hall() {
  PointCloud cloud;
  for (float x = -10.0F; x <= 10.0F; x += 0.2F) {
    for (float y = -3.0F; y <= 3.0F; y += 0.2F) {
      cloud.points.push_back({x, y, static_cast<float>(-kHeight), 0.5F});
    }
  }
  return cloud;
}

/// Nothing but a wall at the side.
PointCloud wall() {
  PointCloud cloud;
  for (float x = -10.0F; x <= 10.0F; x += 0.1F) {
    for (float z = -3.0F; z <= 3.0F; z += 0.1F) cloud.points.push_back({x, 1.0F, z, 0.5F});
  }
  return cloud;
}

class FloorDetectionNode : public testing::Test {
 protected:
  FloorDetectionNode()
      : node_("floor_detection_node",
              {"_sensor_height:=" + std::to_string(kHeight), "_base_frame:=car"}),
        clouds_(connected_publisher<sensor_msgs::PointCloud2>("synced_cloud")) {
    EXPECT_TRUE(wait_until([&] { return floors_.connected(); })) << node_.output();
  }
  void send(int step, const PointCloud& cloud) {
    clouds_.publish(ros_border::to_message(cloud, stamp_of(step), "car"));
  }

  NodeProcess node_;
  ros::Publisher clouds_;
  Listener<FloorMessage> floors_{"floor"};
};

/// A scan without a floor is an answer, too: who waits for that of each scan gets it.
TEST_F(FloorDetectionNode, AnswersEveryScanWhetherThereIsAFloorOrNot) {
  send(0, hall());
  send(1, wall());
  send(2, PointCloud());
  send(3, hall());
  ASSERT_TRUE(floors_.wait_for(4)) << node_.output();
  for (int i = 0; i < 4; ++i) {
    const FloorMessage& message = floors_.messages[i];
    EXPECT_EQ(from_ros(message.header.stamp), stamp_of(i));
    EXPECT_EQ(message.header.frame_id, "car");
    EXPECT_EQ(message.found != 0, i == 0 || i == 3) << i;
  }
  const Floor floor = ros_border::from_message(floors_.messages[0]);
  EXPECT_NEAR(floor.normal.z(), 1.0, 1e-3);
  EXPECT_NEAR(floor.offset, kHeight, 0.01);
  EXPECT_GT(floor.inliers, 200);
}

TEST_F(FloorDetectionNode, GivesCloudsOfTheScansWhileSomebodySubscribes) {
  send(0, hall());
  ASSERT_TRUE(floors_.wait_for(1)) << node_.output();
  Listener<sensor_msgs::PointCloud2> filtered("floor_filtered_points");
  Listener<sensor_msgs::PointCloud2> inliers("floor_points");
  ASSERT_TRUE(wait_until([&] { return filtered.connected() && inliers.connected(); }));
  send(1, hall());
  send(2, wall());
  ASSERT_TRUE(filtered.wait_for(2) && inliers.wait_for(2)) << node_.output();
  EXPECT_EQ(from_ros(filtered.messages[0].header.stamp), stamp_of(1)) << "nothing old is kept";
  EXPECT_EQ(from_ros(inliers.messages[0].header.stamp), stamp_of(1));
  EXPECT_EQ(filtered.messages[0].header.frame_id, "car");
  EXPECT_EQ(inliers.messages[0].header.frame_id, "car");
  ASSERT_TRUE(floors_.wait_for(3));
  EXPECT_EQ(inliers.messages[0].width, floors_.messages[1].inliers);
  EXPECT_GE(filtered.messages[0].width, inliers.messages[0].width);
  for (const Point& point : ros_border::from_message(inliers.messages[0]).points) {
    EXPECT_NEAR(point.z, -kHeight, 0.01);
  }
  EXPECT_EQ(inliers.messages[1].width, 0U) << "a wall is no floor";
}

}  // namespace
}  // namespace lidar_mapping::test
