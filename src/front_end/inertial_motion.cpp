#include "lidar_mapping/front_end/inertial_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

namespace lidar_mapping::front_end {
namespace {

/// Gravity is the mean specific force of so many seconds, or of what there is, but of no less.
constexpr double kLongLook = 1.0;
constexpr double kShortLook = 0.2;
/// Between instants of the motion within a sweep, s: a straight line between them is off by 1e-5
/// rad at 5 rad/s.
constexpr double kStep = 0.002;
/// The mean specific force is gravity's to this share, in the right unit.
constexpr double kStandardGravity = 9.80665;  // m/s^2
constexpr double kOtherForce = 0.3;
/// So many steps after it is distrusted an IMU is tried anew.
constexpr int kBeginsAnew = 50;
constexpr double kLongestStep = 5.0;  ///< s, from sweep to sweep

using registration::MotionBelief;

/// Where the IMU was at the steps, with the axes and from the place at the first one, falling
/// freely and starting at rest.
std::vector<Preintegration> integrated(const ImuTrack& track, Stamp begin, std::size_t count,
                                       const ImuBias& bias) {
  std::vector<Preintegration> sums{{}};
  for (std::size_t k = 1; k < count; ++k) {
    const Stamp from = begin + static_cast<Stamp>(k - 1) * from_seconds(kStep);
    const auto samples = track.between(from, from + from_seconds(kStep));
    Preintegration sum = sums.back();
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const ImuSample& a = samples[i - 1];
      const ImuSample& b = samples[i];
      sum.add(0.5 * (a.angular_velocity + b.angular_velocity) - bias.gyro,
              0.5 * (a.linear_acceleration + b.linear_acceleration) - bias.accelerometer,
              to_seconds(b.stamp - a.stamp));
    }
    sums.push_back(sum);
  }
  return sums;
}

}  // namespace

void InertialMotion::add(const MotionPrior& prior) {
  uniform_rate_.reset();
  if (!prior.imu) return;
  track_.add(*prior.imu);
  uniform_rate_ = prior.imu->uniform_rate;
  removed_bias_ = prior.imu->gyro_bias;
}

/// Whatever accelerates the sensor, on the mean of a second it is carried.
bool InertialMotion::look_down(Stamp reference, const Pose& T_odom_base) {
  if (track_.empty()) return false;
  const Stamp begin = std::max(track_.oldest(), reference - from_seconds(kLongLook));
  if (reference - begin < from_seconds(kShortLook) || !track_.covers(begin, reference)) {
    return false;
  }
  const Preintegration look = preintegrated(track_.between(begin, reference), {});
  const Eigen::Vector3d force = look.rotation.conjugate() * look.velocity / look.seconds;
  weighs_ = std::abs(force.norm() - kStandardGravity) < kOtherForce * kStandardGravity;
  const Eigen::Vector3d up = weighs_ ? force : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  filter_.begin(T_odom_base, track_.p_base_imu(), -(T_odom_base.rotation * up));
  return true;
}

void InertialMotion::begin(Stamp reference, double since_stamp, double duration,
                           const Pose& T_odom_base) {
  reference_ = reference;
  since_stamp_ = since_stamp;
  duration_ = duration;
  begun_ = is_current_ = look_down(reference, T_odom_base);
  gyro_there_ = accelerometer_there_ = false;
}

void InertialMotion::predict(Stamp reference, double since_stamp, double duration) {
  const Stamp last = last_ = std::exchange(reference_, reference);
  since_stamp_ = since_stamp;
  duration_ = duration;
  const Stamp begin = std::min(last, reference - from_seconds(0.5 * duration));
  const Stamp end = reference + from_seconds(0.5 * duration);
  gyro_there_ = is_current_ && reference > last && reference - last < from_seconds(kLongestStep) &&
                track_.covers(begin, end) &&
                !track_.is_clipped(begin, end, &ImuSample::angular_velocity);
  accelerometer_there_ =
      gyro_there_ && weighs_ && !track_.is_clipped(begin, end, &ImuSample::linear_acceleration);
  is_current_ = gyro_there_;
  if (!gyro_there_) return;
  const ImuBias bias = filter_.state().bias;
  filter_.predict(preintegrated(track_.between(last, reference), bias), accelerometer_there_);
  rate_ = track_.at(reference).angular_velocity;
  if (duration > 0.0) {
    const Stamp half = from_seconds(0.5 * duration);
    const Preintegration turn =
        preintegrated(track_.between(reference - half, reference + half), bias);
    rate_ = log_so3(turn.rotation) / turn.seconds + bias.gyro;
  }
  believed_ = filter_.belief(rate_, duration);
  track_.forget_before(last - from_seconds(kLongLook));
}

ImuUse InertialMotion::use() const {
  const ImuUse trust = monitor_.use();
  if (trust == ImuUse::kDistrusted) return trust;
  if (!gyro_there_) return ImuUse::kAbsent;
  if (trust == ImuUse::kFull && !accelerometer_there_) return ImuUse::kGyro;
  return trust;
}

/// An IMU that nobody knows yet may be in degrees.
bool InertialMotion::is_believed() const {
  return monitor_.use() == ImuUse::kFull || monitor_.use() == ImuUse::kGyro;
}

MotionPrior InertialMotion::heeded(MotionPrior prior) const {
  if (prior.imu && !is_believed()) prior.angular_velocity.reset();
  return prior;
}

MotionFilter InertialMotion::fused(MotionFilter filter) const {
  if (use() == ImuUse::kFull) return filter.believing(believed_);
  if (use() != ImuUse::kGyro) return filter;
  const Matrix12d covariance = believed_.information.inverse();
  const auto sigma = [&](int block) {
    return std::sqrt(covariance.block<3, 3>(block, block).trace() / 3.0);
  };
  filter.measure_attitude(believed_.state.T_map_sensor.rotation, sigma(3));
  filter.measure_rate(believed_.state.twist.tail<3>(), sigma(9));
  return filter;
}

/// Steps over the sweep and the stamp, one of them at the reference time.
FollowedMotion InertialMotion::knots() const {
  const double first = std::min(-0.5 * duration_, -since_stamp_);
  const double last = std::max(0.5 * duration_, -since_stamp_);
  const auto before = static_cast<std::size_t>(std::ceil(-first / kStep));
  const auto after = static_cast<std::size_t>(std::max(1.0, std::ceil(last / kStep)));
  FollowedMotion motion;
  motion.step = kStep;
  motion.begin = -kStep * static_cast<double>(before);
  motion.T_reference_base.resize(before + after + 1);
  return motion;
}

FollowedMotion InertialMotion::followed(const MotionState& believed) const {
  FollowedMotion motion = knots();
  const auto sums =
      integrated(track_, at(motion.begin), motion.T_reference_base.size(), filter_.state().bias);
  const auto reference = static_cast<std::size_t>(std::lround(-motion.begin / kStep));
  const Preintegration& middle = sums[reference];
  const Eigen::Vector3d& arm = track_.p_base_imu();
  const Eigen::Vector3d u = believed.twist.head<3>() + believed.twist.tail<3>().cross(arm);
  const Eigen::Vector3d g = believed.T_map_sensor.rotation.conjugate() * filter_.state().gravity;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const double s = motion.begin + kStep * static_cast<double>(k);
    Pose& pose = motion.T_reference_base[k];
    pose.rotation = (middle.rotation.conjugate() * sums[k].rotation).normalized();
    if (use() != ImuUse::kFull) {
      pose.translation = moved(Pose::Identity(), believed.twist, s).translation;
      continue;
    }
    const Eigen::Vector3d fallen = sums[k].position - middle.position - s * middle.velocity;
    pose.translation =
        s * u + 0.5 * s * s * g + middle.rotation.conjugate() * fallen + arm - pose.rotation * arm;
  }
  return motion;
}

/// As preprocessing turned them: by exp(-rate t) R(t) with R as its gyro's bias makes it, and as
/// the stamps came.
void InertialMotion::undo_turning(FollowedMotion& motion) const {
  if (!uniform_rate_) return;
  const auto turned =
      integrated(track_, at(motion.begin) - track_.delay(), motion.T_reference_base.size(),
                 {removed_bias_, Eigen::Vector3d::Zero()});
  FollowedMotion turning = motion;
  for (std::size_t k = 0; k < turned.size(); ++k) {
    turning.T_reference_base[k] = {turned[k].rotation, Eigen::Vector3d::Zero()};
  }
  const Eigen::Quaterniond at_stamp = turning.at(-since_stamp_).rotation;
  for (std::size_t k = 0; k < turned.size(); ++k) {
    const double t = motion.begin + kStep * static_cast<double>(k) + since_stamp_;
    motion.R_seen_moved.push_back(turned[k].rotation.conjugate() * at_stamp *
                                  exp_so3(*uniform_rate_ * t));
  }
}

std::optional<InertialSweep> InertialMotion::sweep(const MotionState& believed) const {
  if (duration_ <= 0.0) return std::nullopt;
  if (!is_believed()) {
    if (!uniform_rate_ || track_.empty()) return std::nullopt;
    FollowedMotion still = knots();
    undo_turning(still);
    return InertialSweep(still, Vector6d::Zero(), since_stamp_);
  }
  if (use() == ImuUse::kAbsent) return std::nullopt;
  FollowedMotion motion = followed(believed);
  undo_turning(motion);
  return InertialSweep(motion, believed.twist, since_stamp_);
}

/// What a wrong IMU has made of biases and gravity is of no use once it is right again.
void InertialMotion::begin_anew_if_distrusted() {
  distrusted_ = monitor_.use() == ImuUse::kDistrusted ? distrusted_ + 1 : 0;
  if (distrusted_ < kBeginsAnew) return;
  distrusted_ = 0;
  begun_ = is_current_ = false;
  filter_ = InertialFilter();
}

void InertialMotion::learn_delay(const Pose& matched) {
  const Vector6d error = difference(believed_.state.T_map_sensor, matched);
  delay_.update(error.tail<3>(),
                track_.at(reference_).angular_velocity - track_.at(last_).angular_velocity);
  track_.set_delay(from_seconds(delay_.seconds()));
}

void InertialMotion::correct(const registration::NdtMatch& match, const Pose& without) {
  if (gyro_there_) {
    learn_delay(match.state.T_map_sensor);
    monitor_.update(believed_.state.T_map_sensor, without, match.state.T_map_sensor);
    filter_.correct(believed_, match.state, match.points_information, duration_);
    begin_anew_if_distrusted();
    return;
  }
  if (!begun_) begun_ = look_down(reference_, match.state.T_map_sensor);
  if (!begun_) return;
  filter_.resume(match.state, match.information.inverse());
  is_current_ = true;
}

void InertialMotion::bridge(MotionFilter& filter) const {
  if (use() == ImuUse::kFull) {
    filter.restart(believed_.state, believed_.information.inverse());
  }
}

}  // namespace lidar_mapping::front_end
