#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/gyro_bias.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_motion.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/preprocessing/sensor_stream.hpp"
#include "lidar_mapping/preprocessing/velocity_check.hpp"

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

  /// In base_link; nothing in a gap, without a transform, or without the sensor, and no velocity
  /// that the other sensors contradict.
  std::optional<ImuSample> imu_at(Stamp stamp) const;
  std::optional<VelocitySample> velocity_at(Stamp stamp) const;

  /// The samples of the IMU after `after`, until the end of a scan; none without a transform.
  std::optional<ImuStretch> imu_since(Stamp after, Stamp until) const;

  /// The motion over the time span of a scan, by the gyro (else the turning of the velocity) and
  /// the velocity. With the gyro alone only the turning is known (kImu).
  MeasuredMotion motion(Stamp stamp, const TimeSpan& span) const;

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
  bool gyro_is_absurd() const { return gyro_is_absurd_; }
  void give_up_silent_sensors();
  void clear();

 private:
  std::optional<bool> is_standing(Stamp stamp) const;
  std::optional<VelocitySample> measured_velocity_at(Stamp stamp) const;
  bool outturns_velocity(const ImuSample& sample, const std::string& frame_id) const;

  const Extrinsics& extrinsics_;
  double acceleration_unit_;
  double angular_unit_;
  bool estimate_bias_;
  Stamp imu_offset_;
  Stamp velocity_offset_;
  SensorStream<ImuSample> imu_;
  SensorStream<VelocitySample> velocity_;
  GyroBias gyro_bias_;
  VelocityCheck velocity_check_;
  int fast_samples_ = 0;  ///< in a row
  std::optional<Stamp> outturns_since_;
  bool gyro_is_absurd_ = false;
  bool velocity_turns_ = false;  ///< its angular part has been something else than zero
};

}  // namespace lidar_mapping::preprocessing
