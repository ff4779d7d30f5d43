#include "lidar_mapping/front_end/imu_monitor.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

constexpr double kLearningRate = 0.1;
/// So many steps are looked at before an IMU is used.
constexpr int kFirstSteps = 5;
/// Errors below these are no matter: matches err as much.
constexpr double kSmallAngle = 2e-3;  // rad
constexpr double kSmallWay = 0.02;    // m
/// An IMU that was believed may be that much worse (its error, not the square) before it is not
/// believed any more: in a single step chance decides.
constexpr double kClearlyWorse = 1.5;

bool is_worse(double by_imu, double without, double small, double factor) {
  return by_imu > factor * factor * without + small * small;
}

}  // namespace

const char* to_string(ImuUse use) {
  switch (use) {
    case ImuUse::kAbsent:
      return "absent";
    case ImuUse::kFull:
      return "full";
    case ImuUse::kGyro:
      return "gyro";
    case ImuUse::kDistrusted:
      return "distrusted";
  }
  return "";
}

std::string imu_notice(ImuUse use) {
  if (use == ImuUse::kGyro) {
    return "imu: the accelerometer does not agree with the matched motion, so the gyro is used "
           "alone; check imu_acceleration_unit, the axes (tf) and the range of the sensor";
  }
  if (use == ImuUse::kDistrusted) {
    return "imu: the gyro does not agree with the matched motion, so the IMU is not used; check "
           "imu_angular_unit, imu_time_offset, the axes (tf) and the range of the sensor";
  }
  return "";
}

void ImuMonitor::Errors::update(const Pose& predicted, const Pose& matched, double rate) {
  const Vector6d d = difference(predicted, matched);
  translation += rate * (d.head<3>().squaredNorm() - translation);
  rotation += rate * (d.tail<3>().squaredNorm() - rotation);
}

void ImuMonitor::update(const Pose& by_imu, const Pose& without, const Pose& matched) {
  ++steps_;
  const double rate = std::max(kLearningRate, 1.0 / static_cast<double>(steps_));
  by_imu_.update(by_imu, matched, rate);
  without_.update(without, matched, rate);
  if (steps_ < kFirstSteps) return;
  const double for_gyro = use_ == ImuUse::kDistrusted ? 1.0 : kClearlyWorse;
  const double for_both = use_ == ImuUse::kFull ? kClearlyWorse : 1.0;
  if (is_worse(by_imu_.rotation, without_.rotation, kSmallAngle, for_gyro)) {
    use_ = ImuUse::kDistrusted;
  } else if (is_worse(by_imu_.translation, without_.translation, kSmallWay, for_both)) {
    use_ = ImuUse::kGyro;
  } else {
    use_ = ImuUse::kFull;
  }
}

}  // namespace lidar_mapping::front_end
