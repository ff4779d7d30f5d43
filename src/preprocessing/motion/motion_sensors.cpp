// SPDX-License-Identifier: BSD-3-Clause
#include "motion/motion_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/interpolation.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// m/s. Chosen above the resolution of wheel encoders and of Doppler velocities, below any motion.
constexpr double kMaxStandingSpeed = 0.05;
/// Samples in a row beyond kMaxVehicleTurnRate: 0.1 s at 200 Hz. Chosen: a shock is shorter.
constexpr int kMaxShockSamples = 20;
constexpr double kMinTurnRate = 0.02;  // rad/s; chosen above the noise of gyros
/// A gyro in degrees/s gives 57 times the rate of the velocity; chosen between that and 1.
constexpr double kMaxTurnRatio = 20.0;
/// A filtered velocity shows a turn later than the gyro, but not later than this.
constexpr Stamp kMaxLag = from_seconds(0.5);
/// At the ends of a scan the nearest sample is used if its distance is not larger than this.
constexpr Stamp kMaxExtrapolation = from_seconds(0.02);
/// The specific force is taken as linear between samples up to this distance; beyond, some are
/// missing. Chosen: that of an IMU at 50 Hz.
constexpr Stamp kMaxForceStep = from_seconds(0.02);

/// The value at `stamp`; just outside of the samples the nearest one, but not farther away.
template <typename Sample>
std::optional<Sample> value_near(const SensorStream<Sample>& stream, Stamp stamp) {
  if (const auto pair = stream.around(stamp)) {
    return interpolated(*pair->first, *pair->second, stamp);
  }
  const auto& buffer = stream.buffer();
  if (buffer.empty()) return std::nullopt;
  const Stamp past_end = stamp - buffer.newest().stamp;
  if (past_end > 0 && past_end <= kMaxExtrapolation) return buffer.newest();
  const Stamp before_begin = buffer.oldest().stamp - stamp;
  if (before_begin > 0 && before_begin <= kMaxExtrapolation) return buffer.oldest();
  return std::nullopt;
}

/// The angular velocity of base_link in its axes by a velocity sensor, over the time since a stamp
/// (s).
TurningAtTime turning_by(const SensorStream<VelocitySample>& velocity,
                         const Eigen::Quaterniond& R_base_velocity, Stamp stamp) {
  return [&velocity, R_base_velocity, stamp](double time) -> std::optional<Eigen::Vector3d> {
    const auto sample = value_near(velocity, stamp + from_seconds(time));
    if (!sample) return std::nullopt;
    return R_base_velocity * sample->angular;
  };
}

/// The velocity of a point of base_link in its axes, over the time since a stamp (s).
VelocityAtTime velocity_by(const SensorStream<VelocitySample>& velocity,
                           const Pose& T_base_velocity, const Eigen::Vector3d& p_base,
                           Stamp stamp) {
  return [&velocity, T_base_velocity, p_base, stamp](
             double time, const Eigen::Vector3d& omega) -> std::optional<Eigen::Vector3d> {
    const auto sample = value_near(velocity, stamp + from_seconds(time));
    if (!sample) return std::nullopt;
    const Eigen::Vector3d lever = p_base - T_base_velocity.translation;
    return T_base_velocity.rotation * sample->linear + omega.cross(lever);
  };
}

bool is_orientation(const Eigen::Quaterniond& q) {
  return q.coeffs().allFinite() && std::abs(q.norm() - 1.0) < 0.05;
}

}  // namespace

MotionSensors::MotionSensors(const PreprocessingConfig& config, const Extrinsics& extrinsics)
    : extrinsics_(extrinsics),
      acceleration_unit_(si_factor(config.imu_acceleration_unit)),
      angular_unit_(si_factor(config.imu_angular_unit)),
      estimate_bias_(config.estimate_gyro_bias),
      imu_offset_(from_seconds(config.imu_time_offset)),
      velocity_offset_(from_seconds(config.velocity_time_offset)),
      imu_("imu", config.use_imu, config.imu_max_gap),
      velocity_("velocity", config.use_velocity, config.velocity_max_gap) {}

Insertion MotionSensors::add_imu(ImuSample sample, const std::string& frame_id) {
  if (!is_plausible(sample)) return Insertion::kRefused;
  sample.stamp += imu_offset_;
  sample.linear_acceleration *= acceleration_unit_;
  sample.angular_velocity *= angular_unit_;
  if (sample.orientation) {
    if (is_orientation(*sample.orientation)) {
      sample.orientation->normalize();
    } else {
      sample.orientation.reset();
    }
  }
  return imu_.insert(std::move(sample), frame_id);
}

void MotionSensors::update_until(Stamp stamp) {
  imu_.buffer().for_each(learned_until_, stamp,
                         [this](const ImuSample& sample) { update(sample); });
  learned_until_ = std::max(learned_until_, stamp);
}

void MotionSensors::update(const ImuSample& sample) {
  judge_rates(sample);
  if (sample.has_angular_velocity) gyro_limits_.add(sample.angular_velocity);
  if (sample.has_linear_acceleration) acceleration_limits_.add(sample.linear_acceleration);
  accelerations_.add(sample);
  const bool has_both = sample.has_angular_velocity && has_valid_acceleration(sample);
  if (estimate_bias_ && has_both && !implausible_since_) {
    gyro_bias_.add(sample, is_standing(sample.stamp));
  }
}

/// Rates are implausible from the sample on that, together with the previous ones, is not possible
/// for a vehicle.
void MotionSensors::judge_rates(const ImuSample& sample) {
  if (implausible_since_) return;
  fast_samples_ = sample.angular_velocity.norm() > kMaxVehicleTurnRate ? fast_samples_ + 1 : 0;
  if (!exceeds_velocity_turn_rate(sample)) {
    exceeds_since_.reset();
  } else if (!exceeds_since_) {
    exceeds_since_ = sample.stamp;
  }
  if (fast_samples_ >= kMaxShockSamples ||
      (exceeds_since_ && sample.stamp - *exceeds_since_ > kMaxLag)) {
    implausible_since_ = sample.stamp;
  }
}

/// True if the gyro's rate is much larger than that of the velocity.
bool MotionSensors::exceeds_velocity_turn_rate(const ImuSample& sample) const {
  const VelocitySample* velocity = velocity_.buffer().up_to(sample.stamp);
  if (!velocity_turns(sample.stamp) || !velocity || sample.stamp > velocity->stamp + kMaxLag) {
    return false;
  }
  const auto T_base_imu = extrinsics_.T_base(imu_.frame_id());
  const auto T_base_velocity = extrinsics_.T_base(velocity_.frame_id());
  if (!T_base_imu || !T_base_velocity) return false;
  const Eigen::Quaterniond R_velocity_imu =
      T_base_velocity->rotation.conjugate() * T_base_imu->rotation;
  const double turning = std::abs((R_velocity_imu * sample.angular_velocity).z());
  const double reference = std::abs(velocity->angular.z());
  return reference > kMinTurnRate && turning > kMaxTurnRatio * reference;
}

Insertion MotionSensors::add_velocity(VelocitySample sample, const std::string& frame_id) {
  if (!is_plausible(sample)) return Insertion::kRefused;
  sample.stamp += velocity_offset_;
  if (!sample.angular.isZero(0.0)) {
    turns_since_ = std::min(turns_since_.value_or(sample.stamp), sample.stamp);
  }
  return velocity_.insert(std::move(sample), frame_id);
}

std::optional<bool> MotionSensors::is_standing(Stamp stamp) const {
  const VelocitySample* velocity = velocity_.buffer().up_to(stamp);
  if (!velocity || to_seconds(stamp - velocity->stamp) > 1.0) return std::nullopt;
  return velocity->linear.norm() < kMaxStandingSpeed;
}

std::optional<ImuSample> MotionSensors::imu_at(Stamp stamp) const {
  const auto pair = imu_.around(stamp);
  if (!pair) return std::nullopt;
  const auto T_base_imu = extrinsics_.T_base(imu_.frame_id());
  if (!T_base_imu) return std::nullopt;
  ImuSample sample = interpolated(*pair->first, *pair->second, stamp);
  const auto omega = turning(sample, gyro_bias_.at(stamp));
  sample.has_angular_velocity = omega.has_value();
  if (omega) sample.angular_velocity = *omega;
  if (!has_valid_acceleration(sample)) {
    sample.has_linear_acceleration = false;
    sample.linear_acceleration.setZero();
  }
  return in_base(sample, *T_base_imu);
}

std::optional<Eigen::Vector3d> MotionSensors::turning(const ImuSample& sample,
                                                      const Eigen::Vector3d& bias) const {
  if (!sample.has_angular_velocity || (implausible_since_ && sample.stamp >= *implausible_since_) ||
      gyro_limits_.reaches_limit(sample.angular_velocity)) {
    return std::nullopt;
  }
  return sample.angular_velocity - bias;
}

/// True if its acceleration is plausible.
bool MotionSensors::has_valid_acceleration(const ImuSample& sample) const {
  return sample.has_linear_acceleration && accelerations_.problem() == AccelerationProblem::kNone &&
         !acceleration_limits_.reaches_limit(sample.linear_acceleration);
}

std::optional<FeltForce> MotionSensors::mean_force_between(Stamp begin, Stamp end) const {
  const auto T_base_imu = extrinsics_.T_base(imu_.frame_id());
  const auto first = imu_.around(begin);
  const auto last = imu_.around(end);
  if (!T_base_imu || !first || !last || begin >= end) return std::nullopt;
  ImuSample before = interpolated(*first->first, *first->second, begin);
  bool is_complete = has_valid_acceleration(before);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto add = [&](const ImuSample& sample) {
    const Stamp step = sample.stamp - before.stamp;
    is_complete = is_complete && has_valid_acceleration(sample) && step <= kMaxForceStep;
    sum += 0.5 * to_seconds(step) * (before.linear_acceleration + sample.linear_acceleration);
    before = sample;
  };
  imu_.buffer().for_each(begin, end, add);
  add(interpolated(*last->first, *last->second, end));
  if (!is_complete) return std::nullopt;
  return FeltForce{begin, T_base_imu->rotation * sum / to_seconds(end - begin),
                   T_base_imu->translation};
}

std::optional<VelocitySample> MotionSensors::velocity_at(Stamp stamp) const {
  const auto sample = measured_velocity_at(stamp);
  if (!sample || problem_of(*sample) != VelocityProblem::kNone) return std::nullopt;
  return in_base(*sample, *extrinsics_.T_base(velocity_.frame_id()));
}

std::optional<VelocitySample> MotionSensors::measured_velocity_at(Stamp stamp) const {
  const auto pair = velocity_.around(stamp);
  if (!pair) return std::nullopt;
  const auto T_base_velocity = extrinsics_.T_base(velocity_.frame_id());
  if (!T_base_velocity) return std::nullopt;
  VelocitySample sample = interpolated(*pair->first, *pair->second, stamp);
  if (!velocity_turns(stamp)) {
    // Only the speed was measured; the lever arm needs the angular velocity, which the gyro
    // measures.
    if (const auto imu = imu_at(stamp); imu && imu->has_angular_velocity) {
      sample.angular = T_base_velocity->rotation.conjugate() * imu->angular_velocity;
    }
  }
  return sample;
}

void MotionSensors::check_velocity(Stamp stamp) {
  const auto velocity = measured_velocity_at(stamp);
  const auto imu = imu_at(stamp);
  if (!velocity || !imu || !imu->has_angular_velocity) return;
  const auto T_base_velocity = extrinsics_.T_base(velocity_.frame_id());
  const Eigen::Vector3d omega = T_base_velocity->rotation.conjugate() * imu->angular_velocity;
  velocity_check_.add_turn_rate(stamp, velocity->linear, omega.z());
}

void MotionSensors::check_velocity(const LocalFix& fix) {
  const auto velocity = measured_velocity_at(fix.stamp);
  if (velocity) velocity_check_.add_fix(fix, velocity->linear.norm());
}

VelocityProblem MotionSensors::velocity_problem(Stamp stamp) const {
  const auto velocity = measured_velocity_at(stamp);
  return velocity ? problem_of(*velocity) : VelocityProblem::kNone;
}

VelocityProblem MotionSensors::problem_of(const VelocitySample& velocity) const {
  const VelocityProblem problem = velocity_check_.problem(velocity.linear);
  if (problem != VelocityProblem::kAside) return problem;
  // Its sensor may be mounted at an angle: then the velocity points ahead in base_link.
  const Eigen::Quaterniond R_base_velocity = extrinsics_.T_base(velocity_.frame_id())->rotation;
  return velocity_check_.problem(R_base_velocity * velocity.linear);
}

MeasuredMotion MotionSensors::motion(Stamp stamp, const TimeSpan& span,
                                     const Eigen::Vector3d& p_base) const {
  const auto T_base_imu = extrinsics_.T_base(imu_.frame_id());
  const auto T_base_velocity = velocity_problem(stamp) == VelocityProblem::kNone
                                   ? extrinsics_.T_base(velocity_.frame_id())
                                   : std::nullopt;
  const Stamp end = stamp + from_seconds(span.end);
  const Eigen::Vector3d bias = gyro_bias_.at(end);
  const TurningAtTime gyro = [&](double time) -> std::optional<Eigen::Vector3d> {
    const auto sample = value_near(imu_, stamp + from_seconds(time));
    const auto omega = sample ? turning(*sample, bias) : std::nullopt;
    if (!omega) return std::nullopt;
    return T_base_imu->rotation * *omega;
  };
  if (T_base_velocity) {
    const VelocityAtTime velocity = velocity_by(velocity_, *T_base_velocity, p_base, stamp);
    if (T_base_imu) {
      if (auto both = integrated(span.begin, span.end, gyro, velocity)) {
        return {MotionSource::kImuAndVelocity, *std::move(both)};
      }
    }
    if (velocity_turns(end)) {
      const TurningAtTime by_velocity = turning_by(velocity_, T_base_velocity->rotation, stamp);
      if (auto with_velocity = integrated(span.begin, span.end, by_velocity, velocity)) {
        return {MotionSource::kVelocity, *std::move(with_velocity)};
      }
    }
  }
  if (T_base_imu) {
    if (auto turning_only = integrated(span.begin, span.end, gyro, nullptr)) {
      return {MotionSource::kImu, *std::move(turning_only)};
    }
  }
  return {};
}

void MotionSensors::give_up_silent_sensors() {
  imu_.give_up_if_silent();
  velocity_.give_up_if_silent();
}

void MotionSensors::clear() {
  imu_.clear();
  velocity_.clear();
  gyro_bias_ = {};
  gyro_limits_ = AxisLimits(kMinGyroLimit);
  acceleration_limits_ = AxisLimits(kMinAccelerationLimit);
  accelerations_ = {};
  learned_until_ = 0;
  fast_samples_ = 0;
  exceeds_since_.reset();
  implausible_since_.reset();
  turns_since_.reset();
  velocity_check_ = {};
}

}  // namespace lidar_mapping::preprocessing
