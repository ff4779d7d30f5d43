// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/odometry_choice.hpp"

#include <cstddef>
#include <optional>
#include <vector>

#include <nav_msgs/Odometry.h>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Length of the part of a recording that is looked at, s. Chosen: a vehicle has driven off by
/// then, and reading it takes less than a second.
constexpr double kExamined = 60.0;
/// Least way between two poses that are compared, m. Chosen: above the noise of wheels and of
/// positions.
constexpr double kStep = 0.1;
/// Longest time between two poses that are compared, s. Chosen: the velocity changes little.
constexpr double kLongest = 0.5;
/// Steps that decide. Chosen: some metres, in which a vehicle starts to turn or not.
constexpr std::size_t kSteps = 20;
/// Largest difference of twist and poses, of the speed. Chosen: wheels slip by less, and other
/// units and axes differ by more.
constexpr double kLargest = 0.2;

/// Compares the twists of an odometry with its poses.
class TwistCheck {
 public:
  void add(const nav_msgs::Odometry& message) {
    const auto pose = valid_pose(message.pose.pose);
    if (!pose || message.child_frame_id.empty()) return;
    const Sample now{from_ros(message.header.stamp), *pose,
                     from_message(message.twist.twist.linear)};
    if (!last_ || now.stamp <= last_->stamp || now.stamp - last_->stamp > from_seconds(kLongest)) {
      last_ = now;
      return;
    }
    const Eigen::Vector3d way = now.pose.translation - last_->pose.translation;
    if (way.norm() < kStep) return;
    compare(*last_, now, way);
    last_ = now;
  }
  bool is_decided() const { return deviations_.size() >= kSteps; }
  bool agrees() const { return is_decided() && median(deviations_) < kLargest; }

 private:
  struct Sample {
    Stamp stamp;
    Pose pose;
    Eigen::Vector3d velocity;
  };

  /// The mean of both twists, each in the axes of its own pose.
  void compare(const Sample& a, const Sample& b, const Eigen::Vector3d& way) {
    const Eigen::Vector3d by_poses = way / to_seconds(b.stamp - a.stamp);
    const Eigen::Vector3d by_twist =
        0.5 * (a.pose.rotation * a.velocity + b.pose.rotation * b.velocity);
    deviations_.push_back((by_twist - by_poses).norm() / by_poses.norm());
  }

  std::optional<Sample> last_;
  std::vector<double> deviations_;
};

bool has_twist(const BagSet& bags, const std::string& topic) {
  BagStream messages = bags.messages_of({topic});
  TwistCheck check;
  std::optional<Stamp> end;
  for (auto message = messages.next(); message && !check.is_decided(); message = messages.next()) {
    if (!end) end = message->recorded + from_seconds(kExamined);
    if (message->recorded > *end) break;
    try {
      if (const auto odometry = message->instantiate<nav_msgs::Odometry>()) check.add(*odometry);
    } catch (const ros::Exception&) {
      continue;  // damage is reported when the messages are read
    }
  }
  return check.agrees();
}

}  // namespace

std::string odometry_with_twist(const BagSet& bags) {
  for (const std::string& topic : topics_of_type(bags, "nav_msgs/Odometry")) {
    if (has_twist(bags, topic)) return topic;
  }
  return "";
}

}  // namespace lidar_mapping::ros_border
