// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Detects vertical motion that the accelerometer measures and the points do not show: in the car
/// of a lift, all visible points move with the sensor. Over two intervals of one second each, the
/// second difference of the positions is the acceleration with triangular weights. The specific
/// force, minus gravity, with the same weights must be equal to it. Only the vertical component is
/// used: gravity together with the accelerometer's bias is learned from the drive, and this
/// component changes little when the sensor tilts.
class VerticalRideDetector {
 public:
  /// Adds a scan at this pose, `seconds` after the previous one, with the mean specific force since
  /// then.
  void add(const Pose& T_odom_base, double seconds, const std::optional<FeltForce>& force);
  /// To be called if the next scan is not connected with the previous ones.
  void interrupt();

  /// True while the sensor moves vertically without points that show it.
  bool is_riding() const { return riding_; }
  /// Vertical distance travelled this way so far, m.
  double distance() const { return distance_; }
  /// The upward direction in odom, as far as it is known.
  Eigen::Vector3d up() const { return gravity_.normalized(); }

 private:
  struct Step {
    double seconds = 0.0;
    /// position of the IMU at the step's end
    Eigen::Vector3d p_odom_imu = Eigen::Vector3d::Zero();
    /// mean specific force during the step, axes of odom
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
  };

  void extend(const Pose& T_odom_base, double seconds, const FeltForce& force);
  std::optional<Eigen::Vector3d> unseen_acceleration() const;
  void learn_gravity(const Eigen::Vector3d& unseen, double seconds);
  void update(double vertical, double seconds);
  void continue_ride(double vertical, double seconds);
  double acceleration_limit() const;

  std::optional<Pose> T_odom_last_;
  std::deque<Step> steps_;
  double span_ = 0.0;  ///< duration of all steps but the first, s
  /// Gravity (upwards) plus the accelerometer's bias: the measured force minus the acceleration
  /// that the points show.
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  double learned_for_ = 0.0;      ///< s
  double variance_ = 0.0;         ///< variance of the vertical component about its mean, (m/s^2)^2
  double suspected_speed_ = 0.0;  ///< m/s upwards, not shown by the points, before the detection
  bool riding_ = false;
  double ride_duration_ = 0.0;  ///< s
  double speed_ = 0.0;          ///< m/s upwards, not shown by the points
  double peak_speed_ = 0.0;
  double quiet_for_ = 0.0;  ///< s without such an acceleration or speed
  double distance_ = 0.0;
};

}  // namespace lidar_mapping::front_end
