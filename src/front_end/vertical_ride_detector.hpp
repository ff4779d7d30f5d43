// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Motion upwards or downwards that the accelerometer feels and the points do not show: the car of
/// a lift goes with the sensor. Over two spans of a second each the second difference of the places
/// is the acceleration, weighted by a triangle; the felt force, less gravity, has to give the same.
/// Only its vertical part is looked at: gravity with the accelerometer's bias is learnt from the
/// drive, and changes little there as the sensor tilts.
class VerticalRideDetector {
 public:
  /// A scan at this pose, `seconds` after the one before, and what was felt since then.
  void add(const Pose& T_odom_base, double seconds, const std::optional<FeltForce>& force);
  /// The next scan does not hang together with those before.
  void interrupt();

  /// The sensor goes up or down unseen.
  bool is_riding() const { return riding_; }
  /// All that it went unseen so far, m.
  double distance() const { return distance_; }
  /// In odom, as far as it is known.
  Eigen::Vector3d up() const { return gravity_.normalized(); }

 private:
  struct Step {
    double seconds = 0.0;
    Eigen::Vector3d p_odom_imu = Eigen::Vector3d::Zero();  ///< at its end
    Eigen::Vector3d force = Eigen::Vector3d::Zero();       ///< mean during it, axes of odom
  };

  void extend(const Pose& T_odom_base, double seconds, const FeltForce& force);
  std::optional<Eigen::Vector3d> unseen_acceleration() const;
  void learn_gravity(const Eigen::Vector3d& unseen, double seconds);
  void update(double vertical, double seconds);
  void continue_ride(double vertical, double seconds);
  double acceleration_limit() const;

  std::optional<Pose> T_odom_last_;
  std::deque<Step> steps_;
  double span_ = 0.0;  ///< s, of all steps but the first
  /// Gravity, upwards, and the accelerometer's bias: what is felt beside the seen acceleration.
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  double learned_for_ = 0.0;      ///< s
  double variance_ = 0.0;         ///< of the vertical part about that, (m/s^2)^2
  double suspected_speed_ = 0.0;  ///< m/s upwards, unseen, before it is sure
  bool riding_ = false;
  double ride_duration_ = 0.0;  ///< s
  double speed_ = 0.0;          ///< m/s upwards, unseen
  double peak_speed_ = 0.0;
  double quiet_for_ = 0.0;  ///< s without unseen acceleration or speed
  double distance_ = 0.0;
};

}  // namespace lidar_mapping::front_end
