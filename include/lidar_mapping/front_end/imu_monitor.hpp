#pragma once

#include <string>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// How far an IMU is used.
enum class ImuUse {
  kAbsent,      ///< no samples, or not long enough to know
  kFull,        ///< gyro and accelerometer predict the motion
  kGyro,        ///< the accelerometer does not agree with the matches: the gyro alone
  kDistrusted,  ///< the gyro does not agree either: as if there were none
};

/// "absent", "full", "gyro", "distrusted".
const char* to_string(ImuUse use);
/// Says what is not used of the IMU and what may be wrong with it; empty where nothing is to be
/// said.
std::string imu_notice(ImuUse use);

/// Holds what an IMU predicted against what was matched, beside what the motion filter predicted
/// without it: whoever has foretold better is believed. So whatever is wrong with an IMU (units,
/// axes, a dead axis, the time), it does no harm for longer than some scans.
class ImuMonitor {
 public:
  /// Errors of two predictions of a pose.
  void update(const Pose& by_imu, const Pose& without, const Pose& matched);
  ImuUse use() const { return use_; }
  void reset() { *this = ImuMonitor(); }

 private:
  /// Running mean squares of the errors, per step.
  struct Errors {
    double rotation = 0.0;     ///< rad^2
    double translation = 0.0;  ///< m^2

    void update(const Pose& predicted, const Pose& matched, double rate);
  };

  Errors by_imu_, without_;
  int steps_ = 0;
  ImuUse use_ = ImuUse::kAbsent;
};

}  // namespace lidar_mapping::front_end
