// SPDX-License-Identifier: BSD-3-Clause
#include <map>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "file_content.hpp"
#include "near.hpp"
#include "recording/kitti_bag.hpp"
#include "simulated_drive/drive_output.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

const simulation::Drive& short_drive() {
  static const simulation::Drive drive([] {
    simulation::DriveOptions options;
    options.drive = "tunnel";
    options.lidar = "vlp16";
    options.duration = 5.0;
    return options;
  }());
  return drive;
}

class DriveOutput : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string bag = (folder.path() / "drive.bag").string();
};

TEST_F(DriveOutput, BagHasKittisTopicsInTheOrderOfDelivery) {
  write_bag(short_drive(), bag, {}, 1);
  const rosbag::Bag written(bag);
  std::map<std::string, std::size_t> count;
  ros::Time last(0, 1);
  for (const rosbag::MessageInstance& message : rosbag::View(written)) {
    EXPECT_GE(message.getTime(), last);
    last = message.getTime();
    ++count[message.getTopic()];
    if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) {
      EXPECT_EQ(ros_border::from_ros(message.getTime()) - ros_border::from_ros(cloud->header.stamp),
                100'000'000);
      EXPECT_EQ(cloud->header.frame_id, "velo_link");
    }
  }
  EXPECT_EQ(count["/kitti/velo/pointcloud"], short_drive().scan_count());
  EXPECT_EQ(count["/ground_truth"], short_drive().scan_count());
  EXPECT_EQ(count["/kitti/oxts/imu"], 501U);
  EXPECT_EQ(count["/kitti/oxts/gps/vel"], 501U);
  EXPECT_EQ(count["/kitti/oxts/gps/fix"], 51U);
  EXPECT_EQ(count["/tf_static"], 1U);
}

TEST_F(DriveOutput, BagHasTheSameBytesForAnyNumberOfThreads) {
  write_bag(short_drive(), bag, {}, 1);
  const std::string other = (folder.path() / "other.bag").string();
  write_bag(short_drive(), other, {}, 3);
  EXPECT_TRUE(test::content_of(bag) == test::content_of(other));
}

TEST_F(DriveOutput, BagHasItsNameOnlyWhenItIsWhole) {
  EXPECT_THROW(write_whole_bag(bag, [](rosbag::Bag&) { throw FileError("a damaged scan"); }),
               FileError);
  EXPECT_FALSE(std::filesystem::exists(bag));
  const std::string nowhere = (folder.path() / "missing" / "drive.bag").string();
  EXPECT_THROW(write_whole_bag(nowhere, [](rosbag::Bag&) {}), FileError);
}

TEST_F(DriveOutput, BagLeavesOutWhatIsNotWanted) {
  BagContent lidar_alone;
  lidar_alone.imu = lidar_alone.gnss = lidar_alone.velocity = false;
  write_bag(short_drive(), bag, lidar_alone, 1);
  const rosbag::Bag written(bag);
  for (const rosbag::MessageInstance& message : rosbag::View(written)) {
    EXPECT_EQ(message.getTopic().find("/kitti/oxts"), std::string::npos);
  }
}

TEST_F(DriveOutput, TruthAndExtrinsicsAreExactAndCloudsNearlySo) {
  write_bag(short_drive(), bag, {}, 1);
  const rosbag::Bag written(bag);
  std::size_t scans = 0;
  for (const rosbag::MessageInstance& message : rosbag::View(written)) {
    if (const auto truth = message.instantiate<nav_msgs::Odometry>()) {
      const Pose T_map_base =
          short_drive().trajectory().pose(ros_border::from_ros(truth->header.stamp));
      EXPECT_TRUE(test::near(ros_border::from_message(truth->pose.pose), T_map_base, 1e-9));
    } else if (const auto tf = message.instantiate<tf2_msgs::TFMessage>()) {
      ASSERT_EQ(tf->transforms.size(), 3U);
      const Pose T_base_lidar = ros_border::from_message(tf->transforms[0].transform);
      EXPECT_TRUE(test::near(T_base_lidar, short_drive().mounting().T_base_lidar, 1e-9));
      EXPECT_EQ((*message.getConnectionHeader())["latching"], "1");
    } else if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) {
      const PointCloud read = ros_border::from_message(*cloud);
      const PointCloud taken = short_drive().scan(scans++).cloud;
      ASSERT_EQ(read.size(), taken.size());
      EXPECT_EQ(read.times, taken.times);
      for (std::size_t i = 0; i < read.size(); ++i) {
        ASSERT_TRUE(test::near(read.points[i].position(), taken.points[i].position(), 0.0035));
      }
    }
  }
  EXPECT_EQ(scans, short_drive().scan_count());
}

TEST_F(DriveOutput, FolderHasAFileOfEachKindPerScan) {
  const auto kitti = folder.path() / "kitti";
  write_folder(short_drive(), kitti.string(), 1);
  const auto taken = short_drive().scan(4);
  EXPECT_EQ(std::filesystem::file_size(kitti / "velodyne/000004.bin"), 16 * taken.cloud.size());
  EXPECT_EQ(std::filesystem::file_size(kitti / "point_times/000004.f32"), 4 * taken.cloud.size());
  EXPECT_EQ(std::filesystem::file_size(kitti / "labels/000004.u8"), taken.cloud.size());
  const Trajectory poses = read_trajectory((kitti / "poses.txt").string());
  ASSERT_EQ(poses.poses.size(), short_drive().scan_count());
  EXPECT_TRUE(test::near(poses.poses.front().pose, Pose::Identity(), 1e-6));
  EXPECT_THROW(write_folder(short_drive(), kitti.string(), 1), FileError);
}

TEST_F(DriveOutput, TruthFileHasAPosePerScan) {
  const std::string path = (folder.path() / "truth.tum").string();
  write_truth(short_drive(), path);
  const Trajectory truth = read_trajectory(path);
  ASSERT_EQ(truth.poses.size(), short_drive().scan_count());
  EXPECT_EQ(truth.poses[7].stamp, short_drive().scan_stamp(7));
}

}  // namespace
}  // namespace lidar_mapping::tools
