// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/transform_odometry.hpp"

#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Longest time between two poses, s. Chosen: over a longer one the mean velocity differs too much
/// from that at an instant.
constexpr double kLongestGap = 0.5;

}  // namespace

TransformOdometry::TransformOdometry(const std::string& odom_frame, const std::string& base_frame)
    : odom_frame_(frame_name(odom_frame)), base_frame_(frame_name(base_frame)) {
  if (!odom_frame_.empty() && odom_frame_ != base_frame_) return;
  throw ConfigError("robot_odom_frame_id: '" + odom_frame +
                    "' is no frame of an odometry; name the frame in which tf has the pose of '" +
                    base_frame + "'");
}

std::vector<VelocitySample> TransformOdometry::add(const tf2_msgs::TFMessage& message) {
  std::vector<VelocitySample> velocities;
  for (const auto& transform : message.transforms) {
    const std::string parent = frame_name(transform.header.frame_id);
    const std::string child = frame_name(transform.child_frame_id);
    const bool upright = parent == odom_frame_ && child == base_frame_;
    if (!upright && !(parent == base_frame_ && child == odom_frame_)) continue;
    const std::optional<Pose> T_parent_child = valid_pose(transform.transform);
    if (!T_parent_child) continue;
    const auto velocity = follow(
        {from_ros(transform.header.stamp), upright ? *T_parent_child : T_parent_child->inverse()});
    if (velocity) velocities.push_back(*velocity);
  }
  return velocities;
}

std::optional<VelocitySample> TransformOdometry::follow(const Known& now) {
  if (last_ && now.stamp == last_->stamp) return std::nullopt;
  const std::optional<Known> before = std::exchange(last_, now);
  if (!before) return std::nullopt;
  const double seconds = to_seconds(now.stamp - before->stamp);
  if (seconds <= 0.0 || seconds > kLongestGap) return std::nullopt;
  const Pose motion = before->T_odom_base.inverse() * now.T_odom_base;
  const Eigen::Vector3d turn = log_so3(motion.rotation);
  VelocitySample sample;
  sample.stamp = before->stamp + (now.stamp - before->stamp) / 2;
  // The axes at the middle of the motion, because the sample has that stamp.
  sample.linear = exp_so3(0.5 * turn).conjugate() * motion.translation / seconds;
  sample.angular = turn / seconds;
  return sample;
}

}  // namespace lidar_mapping::ros_border
