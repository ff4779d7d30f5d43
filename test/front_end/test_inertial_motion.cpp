#include <algorithm>
#include <functional>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "lidar_mapping/front_end/inertial_motion.hpp"

#include "shaken_imu.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::NdtMatch;

/// Matches that find the exact motion but for a millimetre and a third of a milliradian, ten times
/// a second, and an IMU.
class Carried {
 public:
  explicit Carried(const simulation::SmoothTrajectory& motion, std::vector<ImuSample> samples,
                   const Eigen::Vector3d& p_base_imu)
      : motion_(motion), samples_(std::move(samples)), p_base_imu_(p_base_imu) {}

  /// Goes on for so many scans.
  void go(int scans) {
    for (int i = 0; i < scans; ++i) take();
  }

  const InertialMotion& imu() const { return imu_; }
  /// Of the last prediction that was used: m, rad; beside that without the IMU.
  double error() const { return error_; }
  double angle_error() const { return angle_error_; }
  double error_without() const { return error_without_; }
  double largest_error = 0.0;

 private:
  void take() {
    const Stamp reference = from_seconds(1.0 + 0.1 * scan_);
    imu_.add(prior_until(reference + from_seconds(0.05)));
    if (scan_++ == 0) {
      imu_.begin(reference, 0.05, 0.1, motion_.pose(reference));
      filter_.reset(motion_.pose(reference), 15.0, 1.0);
      return;
    }
    filter_.predict(0.1);
    imu_.predict(reference, 0.05, 0.1);
    const Pose truth = motion_.pose(reference);
    const MotionFilter fused = imu_.fused(filter_);
    const Vector6d d = difference(fused.state().T_map_sensor, truth);
    error_ = d.head<3>().norm();
    angle_error_ = d.tail<3>().norm();
    error_without_ = difference(filter_.state().T_map_sensor, truth).head<3>().norm();
    largest_error = std::max(largest_error, error_);
    const NdtMatch match = matched(reference, fused.belief());
    imu_.correct(match, filter_.state().T_map_sensor);
    filter_.correct(match.state, match.information.inverse());
  }

  MotionPrior prior_until(Stamp end) {
    MotionPrior prior;
    prior.imu.emplace();
    prior.imu->p_base_imu = p_base_imu_;
    while (next_ < samples_.size() && samples_[next_].stamp <= end) {
      prior.imu->samples.push_back(samples_[next_++]);
    }
    return prior;
  }

  /// What the points say, and what was believed before.
  NdtMatch matched(Stamp reference, const registration::MotionBelief& believed) {
    const auto state = motion_.state(reference);
    NdtMatch match;
    Vector6d noise;
    for (int i = 0; i < 6; ++i) noise[i] = (i < 3 ? 1e-3 : 3e-4) * normal_(random_);
    match.state.T_map_sensor = perturbed(state.T_map_base, noise);
    match.state.twist << state.T_map_base.rotation.conjugate() * state.velocity_map,
        state.angular_velocity_base;
    Vector12d sigma;
    sigma << 1e-3, 1e-3, 1e-3, 3e-4, 3e-4, 3e-4, 0.05, 0.05, 0.05, 0.02, 0.02, 0.02;
    for (int i = 6; i < 12; ++i) match.state.twist[i - 6] += sigma[i] * normal_(random_);
    match.points_information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    match.information = match.points_information + believed.information;
    const Vector12d step = match.information.inverse() * match.points_information *
                           difference(believed.state, match.state);
    match.state = perturbed(believed.state, step);
    return match;
  }

  const simulation::SmoothTrajectory& motion_;
  std::vector<ImuSample> samples_;
  std::size_t next_ = 0;
  Eigen::Vector3d p_base_imu_;
  InertialMotion imu_;
  MotionFilter filter_{20.0, 10.0};
  int scan_ = 0;
  double error_ = 0.0, angle_error_ = 0.0, error_without_ = 0.0;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

ImuKind consumer() {
  ImuKind kind;
  kind.gyro_bias = {0.01, -0.008, 0.012};
  kind.accelerometer_bias = {0.1, -0.15, 0.05};
  kind.gyro_noise = 0.003;
  kind.accelerometer_noise = 0.05;
  return kind;
}

using Fault = std::function<void(ImuSample&)>;

Carried carried(const simulation::SmoothTrajectory& motion, const Fault& fault = nullptr) {
  const ImuKind kind = consumer();
  std::vector<ImuSample> samples = samples_of(motion, kind);
  if (fault) std::for_each(samples.begin(), samples.end(), fault);
  return Carried(motion, std::move(samples), kind.p_base_imu);
}

// F: bias, gravity and noise are found from the matches, while the sensor moves.
TEST(InertialMotion, FindsGravityAndBiases) {
  const auto motion = shaken_motion(3.0);
  Carried walk = carried(motion);
  walk.go(300);
  ASSERT_EQ(walk.imu().use(), ImuUse::kFull);
  const InertialState& state = walk.imu().filter().state();
  EXPECT_LT((state.bias.gyro - consumer().gyro_bias).norm(), 2e-3);
  EXPECT_LT((state.bias.accelerometer - consumer().accelerometer_bias).norm(), 0.08);
  EXPECT_LT(std::acos(-state.gravity.normalized().z()), 0.01);
}

TEST(InertialMotion, PredictsAShakenSensorToMillimetres) {
  const auto motion = shaken_motion(6.0);
  Carried run = carried(motion);
  run.go(50);
  double with = 0.0, without = 0.0, angle = 0.0;
  for (int i = 0; i < 200; ++i) {
    run.go(1);
    with = std::max(with, run.error());
    angle = std::max(angle, run.angle_error());
    without = std::max(without, run.error_without());
  }
  EXPECT_GT(without, 0.1);
  EXPECT_LT(with, 0.012);
  EXPECT_LT(angle, 2e-3);
}

TEST(InertialMotion, WithoutSamplesDoesNothing) {
  const auto motion = shaken_motion(3.0);
  Carried walk(motion, {}, Eigen::Vector3d::Zero());
  walk.go(50);
  EXPECT_EQ(walk.imu().use(), ImuUse::kAbsent);
  EXPECT_EQ(walk.error(), walk.error_without());
}

// F: an IMU that fails for two seconds is used again afterwards.
TEST(InertialMotion, ComesBackAfterAGap) {
  const auto motion = shaken_motion(3.0);
  const ImuKind kind = consumer();
  std::vector<ImuSample> samples = samples_of(motion, kind);
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [](const ImuSample& s) {
                                 return s.stamp > from_seconds(15.0) &&
                                        s.stamp < from_seconds(17.0);
                               }),
                samples.end());
  Carried walk(motion, samples, kind.p_base_imu);
  walk.go(150);
  EXPECT_EQ(walk.imu().use(), ImuUse::kAbsent);
  walk.go(30);
  EXPECT_EQ(walk.imu().use(), ImuUse::kFull);
  walk.go(50);
  EXPECT_LT(walk.error(), 0.01);
}

// F: stamps that are late by 20 ms are found out and set right.
TEST(InertialMotion, FindsHowLateTheStampsAre) {
  const auto motion = shaken_motion(3.0);
  Carried walk = carried(motion, [](ImuSample& s) { s.stamp += from_seconds(0.02); });
  walk.go(300);
  EXPECT_NEAR(walk.imu().delay(), 0.02, 2e-3);
  EXPECT_EQ(walk.imu().use(), ImuUse::kFull);
  Carried in_time = carried(motion);
  in_time.go(300);
  EXPECT_NEAR(in_time.imu().delay(), 0.0, 5e-4);
}

struct NamedFault {
  const char* name;
  ImuUse use;
  Fault spoil;
};

/// What may be wrong with an IMU, and how much of it is used then.
std::vector<NamedFault> faults() {
  return {
      {"in g", ImuUse::kGyro, [](ImuSample& s) { s.linear_acceleration /= 9.80665; }},
      {"in degrees", ImuUse::kDistrusted, [](ImuSample& s) { s.angular_velocity *= 57.3; }},
      {"turned axes", ImuUse::kDistrusted,
       [](ImuSample& s) {
         const Eigen::AngleAxisd turn(M_PI / 2, Eigen::Vector3d::UnitX());
         s.angular_velocity = turn * s.angular_velocity;
         s.linear_acceleration = turn * s.linear_acceleration;
       }},
      {"dead gyro axis", ImuUse::kDistrusted, [](ImuSample& s) { s.angular_velocity.z() = 0.0; }},
      {"dead accelerometer", ImuUse::kGyro, [](ImuSample& s) { s.linear_acceleration.setZero(); }},
      {"late by 0.1 s", ImuUse::kDistrusted, [](ImuSample& s) { s.stamp += from_seconds(0.1); }},
  };
}

// F: whatever is wrong with an IMU, it is noticed and does no harm.
TEST(InertialMotion, NoticesEveryFault) {
  const auto motion = shaken_motion(4.0);
  for (const NamedFault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    Carried walk = carried(motion, fault.spoil);
    walk.go(30);
    double with = 0.0, without = 0.0;
    int noticed = 0;
    for (int i = 0; i < 300; ++i) {
      walk.go(1);
      with += walk.error() * walk.error();
      without += walk.error_without() * walk.error_without();
      noticed += walk.imu().use() == fault.use ? 1 : 0;
    }
    EXPECT_GT(noticed, 250);
    EXPECT_LT(with, 1.3 * without);
    EXPECT_FALSE(imu_notice(fault.use).empty());
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
