// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_motion.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "checks/accelerometer_check.hpp"
#include "checks/axis_limits.hpp"
#include "checks/velocity_check.hpp"
#include "motion/gyro_bias.hpp"
#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// The sensors from which the motion during a scan was computed.
enum class MotionSource { kNone, kImu, kVelocity, kImuAndVelocity };

struct MeasuredMotion {
  MotionSource source = MotionSource::kNone;
  ScanMotion motion;
};

/// IMU and velocity sensor: their values in base_link at an instant, and the motion during a scan.
class MotionSensors {
 public:
  MotionSensors(const PreprocessingConfig& config, const Extrinsics& extrinsics);

  Insertion add_imu(ImuSample sample, const std::string& frame_id);
  Insertion add_velocity(VelocitySample sample, const std::string& frame_id);

  /// Uses the samples up to `stamp`, in the order of their stamps, to learn the gyro's bias and to
  /// check its rates. So the order in which messages of several sensors arrive has no influence. To
  /// be called when the samples up to `stamp` have arrived.
  void update_until(Stamp stamp);

  /// The values in base_link. Empty in a gap, without a transform, or without the sensor; the
  /// velocity is also empty if the other sensors contradict it.
  std::optional<ImuSample> imu_at(Stamp stamp) const;
  std::optional<VelocitySample> velocity_at(Stamp stamp) const;

  /// The motion of a point of the vehicle over the time span of a scan, from the gyro (or else the
  /// angular part of the velocity) and the velocity. With the gyro alone only the rotation is known
  /// (kImu).
  MeasuredMotion motion(Stamp stamp, const TimeSpan& span, const Eigen::Vector3d& p_base) const;

  /// The mean specific force between two stamps. Empty if samples are missing, at the end of the
  /// measuring range, or not plausible.
  std::optional<FeltForce> mean_force_between(Stamp begin, Stamp end) const;

  /// Checks the velocity against the gyro and against the distances between fixes.
  void check_velocity(Stamp stamp);
  void check_velocity(const LocalFix& fix);
  /// The reason why the velocity at `stamp` is not used, and the message about it.
  VelocityProblem velocity_problem(Stamp stamp) const;
  std::string sentence(VelocityProblem problem) const { return velocity_check_.sentence(problem); }

  const SensorStream<ImuSample>& imu() const { return imu_; }
  const SensorStream<VelocitySample>& velocity() const { return velocity_; }
  /// True if the gyro's rates were faster than any vehicle turns, or much faster than those of the
  /// velocity. They are in degrees/s and are not used any more.
  bool gyro_is_implausible() const { return implausible_since_.has_value(); }
  /// The reason why accelerations are not used, and the message about it.
  AccelerationProblem acceleration_problem() const { return accelerations_.problem(); }
  std::string acceleration_sentence() const { return accelerations_.sentence(); }
  /// The end of the gyro's measuring range as it was found, rad/s: rates that reach it are not
  /// used.
  std::optional<double> gyro_limit() const { return gyro_limits_.lowest(); }
  void give_up_silent_sensors();
  void clear();

 private:
  /// rad/s (57 degrees/s). Chosen: no gyro has a smaller range. A constant rate below it is a turn
  /// or a standstill.
  static constexpr double kMinGyroLimit = 1.0;
  /// m/s^2. Chosen: every accelerometer must be able to measure gravity (9.81) with some margin.
  static constexpr double kMinAccelerationLimit = 11.0;

  void update(const ImuSample& sample);
  void judge_rates(const ImuSample& sample);
  std::optional<bool> is_standing(Stamp stamp) const;
  bool velocity_turns(Stamp stamp) const { return turns_since_ && *turns_since_ <= stamp; }
  /// Angular velocity in the sensor's axes, without bias; empty if the sample has no plausible
  /// rates.
  std::optional<Eigen::Vector3d> turning(const ImuSample& sample,
                                         const Eigen::Vector3d& bias) const;
  bool has_valid_acceleration(const ImuSample& sample) const;
  /// The velocity in its own axes, where it was measured; empty without a transform.
  std::optional<VelocitySample> measured_velocity_at(Stamp stamp) const;
  /// The problem of a velocity, which is given in its own axes.
  VelocityProblem problem_of(const VelocitySample& velocity) const;
  bool exceeds_velocity_turn_rate(const ImuSample& sample) const;

  const Extrinsics& extrinsics_;
  double acceleration_unit_;
  double angular_unit_;
  bool estimate_bias_;
  Stamp imu_offset_;
  Stamp velocity_offset_;
  SensorStream<ImuSample> imu_;
  SensorStream<VelocitySample> velocity_;
  GyroBias gyro_bias_;
  AxisLimits gyro_limits_{kMinGyroLimit};
  AxisLimits acceleration_limits_{kMinAccelerationLimit};
  AccelerometerCheck accelerations_;
  VelocityCheck velocity_check_;
  int fast_samples_ = 0;  ///< number of successive fast samples
  std::optional<Stamp> exceeds_since_;
  Stamp learned_until_ = 0;
  std::optional<Stamp> implausible_since_;
  /// when the angular part of the velocity was not zero for the first time
  std::optional<Stamp> turns_since_;
};

}  // namespace lidar_mapping::preprocessing
