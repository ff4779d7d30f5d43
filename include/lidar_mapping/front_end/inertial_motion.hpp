#pragma once

#include <optional>

#include "lidar_mapping/front_end/imu_delay.hpp"
#include "lidar_mapping/front_end/imu_monitor.hpp"
#include "lidar_mapping/front_end/imu_track.hpp"
#include "lidar_mapping/front_end/inertial_filter.hpp"
#include "lidar_mapping/front_end/inertial_sweep.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::front_end {

/// The motion as an IMU follows it: from sweep to sweep, as what is believed before a match, and
/// within a sweep, so that points lie where they were seen however the sensor shook. As far as the
/// IMU agrees with the matches (ImuMonitor); without samples nothing of it does anything.
class InertialMotion {
 public:
  /// Takes in the samples until the end of the sweep.
  void add(const MotionPrior& prior);
  /// A map begins: at its reference time the first sweep lies at this pose.
  void begin(Stamp reference, double since_stamp, double duration, const Pose& T_odom_base);
  /// Moves on to a sweep of `duration` seconds whose reference time is `since_stamp` seconds after
  /// its scan's stamp.
  void predict(Stamp reference, double since_stamp, double duration);
  /// What other sensors say, without an IMU that is not believed.
  MotionPrior heeded(MotionPrior prior) const;
  /// The filter, predicted without the IMU, with what the IMU says taken in.
  MotionFilter fused(MotionFilter filter) const;
  /// How the sweep's points are to be bent if its motion is believed to be that; nothing where they
  /// are to stay as they came.
  std::optional<InertialSweep> sweep(const MotionState& believed) const;
  /// The sweep was matched; the pose without the IMU was expected to be that.
  void correct(const registration::NdtMatch& match, const Pose& without);
  /// The sweep was not matched: where the IMU says that it was, if it is to be believed.
  void bridge(MotionFilter& filter) const;

  /// As it is used for this sweep.
  ImuUse use() const;
  /// As it agrees with the matches.
  ImuUse trust() const { return monitor_.use(); }
  /// By how much its stamps are late, s.
  double delay() const { return delay_.seconds(); }
  const InertialFilter& filter() const { return filter_; }

 private:
  bool is_believed() const;
  bool look_down(Stamp reference, const Pose& T_odom_base);
  FollowedMotion followed(const MotionState& believed) const;
  void begin_anew_if_distrusted();
  void learn_delay(const Pose& matched);
  void undo_turning(FollowedMotion& motion) const;
  FollowedMotion knots() const;
  Stamp at(double seconds) const { return reference_ + from_seconds(seconds); }

  ImuTrack track_;
  ImuMonitor monitor_;
  ImuDelay delay_;
  InertialFilter filter_;
  std::optional<Eigen::Vector3d> uniform_rate_;  ///< of this sweep, see ImuStretch
  Eigen::Vector3d removed_bias_ = Eigen::Vector3d::Zero();
  bool begun_ = false;       ///< gravity is known roughly
  bool weighs_ = false;      ///< the accelerometer shows gravity
  bool is_current_ = false;  ///< the filter's state is that of the last sweep
  bool gyro_there_ = false;  ///< for this sweep and the way to it
  bool accelerometer_there_ = false;
  int distrusted_ = 0;   ///< steps in a row
  Stamp reference_ = 0;  ///< of this sweep
  Stamp last_ = 0;       ///< of the one before
  double since_stamp_ = 0.0;
  double duration_ = 0.0;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  ///< mean of this sweep, as measured
  registration::MotionBelief believed_;
};

}  // namespace lidar_mapping::front_end
