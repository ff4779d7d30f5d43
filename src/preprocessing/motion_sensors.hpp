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

#include "accelerometer_check.hpp"
#include "axis_limits.hpp"
#include "gyro_bias.hpp"
#include "sensor_stream.hpp"
#include "velocity_check.hpp"

namespace lidar_mapping::preprocessing {

/// How the motion during a scan was found.
enum class MotionSource { kNone, kImu, kVelocity, kImuAndVelocity };
const char* to_string(MotionSource source);

struct MeasuredMotion {
  MotionSource source = MotionSource::kNone;
  ScanMotion motion;
};

/// IMU and velocity: their values in base_link at an instant, and the motion over a scan.
class MotionSensors {
 public:
  MotionSensors(const PreprocessingConfig& config, const Extrinsics& extrinsics);

  Insertion add_imu(ImuSample sample, const std::string& frame_id);
  Insertion add_velocity(VelocitySample sample, const std::string& frame_id);

  /// Learns the gyro's bias and whether its rates can be believed from the samples up to `stamp`,
  /// in the order of the stamps: the order in which messages of several sensors arrive changes
  /// nothing. Called when the samples up to there have come.
  void update_until(Stamp stamp);

  /// In base_link; nothing in a gap, without a transform, or without the sensor, and no velocity
  /// that the other sensors contradict.
  std::optional<ImuSample> imu_at(Stamp stamp) const;
  std::optional<VelocitySample> velocity_at(Stamp stamp) const;

  /// The motion of a point of the vehicle over the time span of a scan, by the gyro (else the
  /// turning of the velocity) and the velocity. With the gyro alone only the turning is known
  /// (kImu).
  MeasuredMotion motion(Stamp stamp, const TimeSpan& span, const Eigen::Vector3d& p_base) const;

  /// The mean of what the accelerometer felt between two stamps; nothing where samples are missing,
  /// are at the end of its range, or are none that can be believed.
  std::optional<FeltForce> mean_force_between(Stamp begin, Stamp end) const;

  /// Holds the velocity against the turning by the gyro and the way of the fixes.
  void check_velocity(Stamp stamp);
  void check_velocity(const LocalFix& fix);
  /// Why the velocity at `stamp` is not used, and that in words.
  VelocityProblem velocity_problem(Stamp stamp) const;
  std::string sentence(VelocityProblem problem) const { return velocity_check_.sentence(problem); }

  const SensorStream<ImuSample>& imu() const { return imu_; }
  const SensorStream<VelocitySample>& velocity() const { return velocity_; }
  /// It turned as nobody drives, or far more than the velocity, so its rates are not used any more:
  /// they are in degrees/s.
  bool gyro_is_implausible() const { return implausible_since_.has_value(); }
  /// Why accelerations are not used, and that in words.
  AccelerationProblem acceleration_problem() const { return accelerations_.problem(); }
  std::string acceleration_sentence() const { return accelerations_.sentence(); }
  /// Where the gyro's range was found to end, rad/s: rates that reach it are not used.
  std::optional<double> gyro_limit() const { return gyro_limits_.lowest(); }
  void give_up_silent_sensors();
  void clear();

 private:
  /// No gyro's range ends below that, rad/s; a rate that is steady there is a turn, or rest.
  static constexpr double kMinGyroLimit = 1.0;
  /// m/s^2: all have to measure gravity.
  static constexpr double kMinAccelerationLimit = 11.0;

  void update(const ImuSample& sample);
  bool is_implausible(const ImuSample& sample);
  std::optional<bool> is_standing(Stamp stamp) const;
  bool velocity_turns(Stamp stamp) const { return turns_since_ && *turns_since_ <= stamp; }
  /// Sensor's axes, without bias; nothing where the sample has no rates that can be believed.
  std::optional<Eigen::Vector3d> turning(const ImuSample& sample,
                                         const Eigen::Vector3d& bias) const;
  bool has_valid_acceleration(const ImuSample& sample) const;
  /// In its own axes, where it was measured; nothing without a transform.
  std::optional<VelocitySample> measured_velocity_at(Stamp stamp) const;
  /// `velocity` in its own axes.
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
  int fast_samples_ = 0;  ///< in a row
  std::optional<Stamp> exceeds_since_;
  Stamp learned_until_ = 0;
  std::optional<Stamp> implausible_since_;
  std::optional<Stamp> turns_since_;  ///< when the velocity's angular part first was not zero
};

}  // namespace lidar_mapping::preprocessing
