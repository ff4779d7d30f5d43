// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::ros_border {

/// The velocity of base_link from an odometry that is only published as transforms, as wheel
/// odometry often is. One thread calls it.
class TransformOdometry {
 public:
  /// Throws ConfigError if `odom_frame` is empty or that of the vehicle.
  TransformOdometry(const std::string& odom_frame, const std::string& base_frame);

  /// The mean velocities from one pose to the next, in the axes of base_link and at the middle of
  /// the time between. Only transforms between the two frames are used, whichever is the parent;
  /// poses that are repeated, go back in time, or follow a gap of more than half a second give
  /// none.
  std::vector<VelocitySample> add(const tf2_msgs::TFMessage& message);

 private:
  struct Known {
    Stamp stamp = 0;
    Pose T_odom_base;
  };

  std::optional<VelocitySample> follow(const Known& now);

  std::string odom_frame_;
  std::string base_frame_;
  std::optional<Known> last_;
};

}  // namespace lidar_mapping::ros_border
