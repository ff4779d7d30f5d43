// SPDX-License-Identifier: BSD-3-Clause
// Clouds in a frame in which the vehicle moves, and odometries of wheels, through the commands.
#include <map>

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "input_forms.hpp"

namespace lidar_mapping::tools {
namespace {

using nav_msgs::Odometry;
using sensor_msgs::PointCloud2;
using test::kTopic;
using test::TimedPoint;

class InputFrames : public test::InputForms {
 protected:
  /// The true pose of the vehicle at the stamp of each scan.
  static std::map<ros::Time, Pose> truth() {
    std::map<ros::Time, Pose> poses;
    Pose T_odom_map;  // near to the drive, where floats hold micrometres
    const rosbag::Bag in(drive(), rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& message : rosbag::View(in)) {
      const auto odometry = message.instantiate<Odometry>();
      if (!odometry) continue;
      const Pose T_map_base = ros_border::from_message(odometry->pose.pose);
      if (poses.empty()) T_odom_map = T_map_base.inverse();
      poses[odometry->header.stamp] = T_odom_map * T_map_base;
    }
    return poses;
  }
  static Pose T_base_lidar() {
    const rosbag::Bag in(drive(), rosbag::bagmode::Read);
    for (const rosbag::MessageInstance& message : rosbag::View(in)) {
      const auto frames = message.instantiate<tf2_msgs::TFMessage>();
      if (!frames) continue;
      for (const auto& t : frames->transforms) {
        if (t.child_frame_id == "velo_link") return ros_border::from_message(t.transform);
      }
    }
    return Pose::Identity();
  }
  static PointCloud2 moved(const PointCloud2& cloud, const Pose& pose, const std::string& frame) {
    std::vector<TimedPoint> points = test::points_of(cloud);
    for (TimedPoint& p : points) {
      const Eigen::Vector3d at = pose * Eigen::Vector3d(p.x, p.y, p.z);
      p.x = static_cast<float>(at.x());
      p.y = static_cast<float>(at.y());
      p.z = static_cast<float>(at.z());
    }
    PointCloud2 result = test::plain_cloud(cloud.header, points);
    result.header.frame_id = frame;
    return result;
  }
  static tf2_msgs::TFMessage transform(const ros::Time& stamp, const Pose& T_odom_base) {
    tf2_msgs::TFMessage message;
    message.transforms = {ros_border::stamped_transform(T_odom_base, ros_border::from_ros(stamp),
                                                        "odom", "base_link")};
    return message;
  }
};

TEST_F(InputFrames, CloudsInAWorldAreTakenBackByTf) {
  const auto poses = truth();
  const Pose T_base = T_base_lidar();
  const auto in_world = [&](rosbag::Bag& to, const ros::Time& recorded, const PointCloud2& cloud) {
    const Pose& T_odom_base = poses.at(cloud.header.stamp);
    to.write("/tf", recorded, transform(cloud.header.stamp, T_odom_base));
    to.write(kTopic, recorded, moved(cloud, T_odom_base * T_base, "odom"));
  };
  const auto on_vehicle = [&](rosbag::Bag& to, const ros::Time& recorded,
                              const PointCloud2& cloud) {
    to.write("/tf", recorded, transform(cloud.header.stamp, poses.at(cloud.header.stamp)));
    to.write(kTopic, recorded, moved(cloud, T_base, "base_link"));
  };
  const std::string world = written("world", in_world);
  expect_equal_poses(mapped(world), mapped(written("vehicle", on_vehicle)));
  expect_said(checked(world), "the clouds are in 'odom', a frame in which 'base_link' moves", 1);
}

/// Without the velocities of the drive, and with an odometry instead.
test::WriteMessage with_odometry(const std::function<void(Odometry&)>& change) {
  return [change](rosbag::Bag& to, const rosbag::MessageInstance& message) {
    if (message.instantiate<geometry_msgs::TwistStamped>()) return true;
    auto odometry = message.instantiate<Odometry>();
    if (!odometry) return false;
    change(*odometry);
    to.write("/odom", message.getTime(), *odometry);
    return true;
  };
}

TEST_F(InputFrames, AnOdometryOfWheelsIsFoundByItsType) {
  const std::string bag = rewritten("wheels", with_odometry([](Odometry&) {}));
  expect_said(checked(bag), "velocity  /odom: 10.0 Hz, frame base_link", 0);
  mapped(bag);
  const auto is_left_out = [&](const std::string& name, const auto& change) {
    const auto said = checked(rewritten(name, with_odometry(change)));
    EXPECT_FALSE(has_said("/odom")) << name;
  };
  is_left_out("empty", [](Odometry& o) { o.twist = {}; });
  is_left_out("kmh", [](Odometry& o) { o.twist.twist.linear.x *= 3.6; });
  is_left_out("sideways",
              [](Odometry& o) { std::swap(o.twist.twist.linear.x, o.twist.twist.linear.y); });
  is_left_out("frameless", [](Odometry& o) { o.child_frame_id.clear(); });
}

TEST_F(InputFrames, ATransformThatComesAtTheEndHoldsFromTheBeginning) {
  const auto late = [](rosbag::Bag& to, const rosbag::MessageInstance& message) {
    if (message.getTopic() != "/tf_static") return false;
    to.write(message.getTopic(), message.getTime() + ros::Duration(7.9), message,
             message.getConnectionHeader());
    return true;
  };
  mapped(rewritten("late", late));
  EXPECT_FALSE(has_said("no transform"));
  EXPECT_TRUE(has_said("frame velo_link"));
}

TEST_F(InputFrames, AnotherParentOfTheVehicleIsNamed) {
  const auto with_odometry_in_tf = [](rosbag::Bag& to, const ros::Time& recorded,
                                      const PointCloud2& cloud) {
    tf2_msgs::TFMessage transforms;
    transforms.transforms.resize(1);
    transforms.transforms[0].header.stamp = cloud.header.stamp;
    transforms.transforms[0].header.frame_id = "/wheels";
    transforms.transforms[0].child_frame_id = "base_link";
    transforms.transforms[0].transform.rotation.w = 1.0;
    to.write("/tf", recorded, transforms);
    to.write(kTopic, recorded, cloud);
  };
  expect_said(checked(written("odometry_in_tf", with_odometry_in_tf)),
              "tf has 'wheels' as the parent of 'base_link'", 0);
}

TEST_F(InputFrames, ScannersOfAPlaneAreLeftOutWithAWord) {
  const auto with_scanner = [](rosbag::Bag& to, const ros::Time& recorded,
                               const PointCloud2& cloud) {
    sensor_msgs::LaserScan scan;
    scan.header = cloud.header;
    scan.ranges.resize(100, 5.0F);
    to.write("/front_scan", recorded, scan);
    to.write(kTopic, recorded, cloud);
  };
  expect_said(checked(written("scanner", with_scanner)),
              "not used: /front_scan (sensor_msgs/LaserScan: a single plane)", 0);
}

}  // namespace
}  // namespace lidar_mapping::tools
