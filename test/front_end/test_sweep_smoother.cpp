// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "motion/sweep_smoother.hpp"
#include "near.hpp"
#include "normalised_error.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kSweep = 0.1;  // s
constexpr int kSlices = 16;
/// Standard deviation of the pose that one slice finds, m and rad.
constexpr double kSliceSigma = 1e-3;

/// Turn about the axis along which the sensor moves (rad), and way (m), at a time (s). Turn and way
/// do not influence each other.
struct Motion {
  std::function<double(double)> turn;
  std::function<double(double)> way;

  Pose pose(double seconds) const {
    return {exp_so3({turn(seconds), 0.0, 0.0}), {way(seconds), 0.0, 0.0}};
  }
};

/// Neither the rate nor the speed changes steadily.
const Motion kSwaying{[](double t) { return 0.1 * std::sin(2.0 * kPi * 2.5 * t); },
                      [](double t) { return t + 0.06 * std::sin(2.0 * kPi * 2.0 * t); }};
const Motion kSteady{[](double t) { return 0.5 * t * t; },
                     [](double t) { return 10.0 * t - t * t; }};

/// Value and slope at the middle of the straight line that fits f best within a sweep.
Eigen::Vector2d fitted_line(const std::function<double(double)>& f, double middle) {
  constexpr int kSamples = 100;
  Eigen::Vector2d line = Eigen::Vector2d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const double u = kSweep * ((i + 0.5) / kSamples - 0.5);
    line += Eigen::Vector2d(f(middle + u), 12.0 / (kSweep * kSweep) * u * f(middle + u)) / kSamples;
  }
  return line;
}

/// The match of a sweep: the straight motion that fits best, and slices that are off it as the true
/// motion is, with some noise.
/// With a `lever` (m) the slices see the way only together with the turn: way + lever turn.
SweepMatcher::Found matched(const Motion& motion, double middle, double lever,
                            std::mt19937& random) {
  const Eigen::Vector2d turn = fitted_line(motion.turn, middle);
  const Eigen::Vector2d way = fitted_line(motion.way, middle);
  SweepMatcher::Found found;
  MotionState& state = found.match.state;
  state.T_map_sensor = {exp_so3({turn[0], 0.0, 0.0}), {way[0], 0.0, 0.0}};
  state.twist[0] = way[1];
  state.twist[3] = turn[1];
  found.match.residual_variance = 1.0;
  std::normal_distribution<double> noise(0.0, kSliceSigma);
  for (int k = 0; k < kSlices; ++k) {
    registration::NdtSlice slice;
    slice.time = kSweep * ((k + 0.5) / kSlices - 0.5);
    const Pose straight = moved(Pose::Identity(), state.twist, slice.time);
    Vector6d deviation =
        difference(Pose::Identity(), state.T_map_sensor.inverse() *
                                         motion.pose(middle + slice.time) * straight.inverse());
    for (double& value : deviation) value += noise(random);
    Matrix6d seen = Matrix6d::Identity();
    seen(3, 3) = lever == 0.0 ? 1.0 : 0.0;
    seen(0, 3) = lever;
    slice.part.hessian = seen.transpose() * seen / (kSliceSigma * kSliceSigma);
    slice.part.gradient = -slice.part.hessian * deviation;
    found.match.slices.push_back(slice);
  }
  return found;
}

/// Sweep after sweep through a filter and a smoother.
struct Drive {
  explicit Drive(Motion moved) : motion(std::move(moved)) { filter.reset(Pose{}, 15.0, 1.0); }

  /// The sweep after `seconds` more.
  void add(double seconds, const std::optional<MeasuredTurning>& turning = std::nullopt) {
    middle += seconds;
    found = matched(motion, middle, lever, random);
    filter.predict(seconds, turning);
    Vector12d sigmas;
    sigmas << Vector6d::Constant(1e-3), Vector6d::Constant(0.03);
    filter.correct(found.match.state, sigmas.cwiseAbs2().asDiagonal());
    smoother.add(found, filter, kSweep);
  }
  MotionAtStamp at(double seconds) const { return smoother.motion_at(seconds, filter, kSweep); }
  /// Contradiction to a gyro that measures this rate, rad/s.
  std::optional<double> contradiction_to(double rate) const {
    return smoother.contradiction_to({rate, 0.0, 0.0}, filter, kSweep);
  }
  MotionState of_match(double seconds) const {
    return steadily_accelerated(filter.state(), filter.acceleration(), kSweep, seconds);
  }

  Motion motion;
  MotionFilter filter{10.0, 20.0};
  SweepSmoother smoother;
  SweepMatcher::Found found;
  std::mt19937 random{3};
  double middle = 0.0;
  double lever = 0.0;
};

/// The turning by a gyro that measures this rate, rad/s.
MeasuredTurning turning_at(double rate) { return {{rate, 0.0, 0.0}, {rate, 0.0, 0.0}, 0.02}; }

/// Root mean square errors of poses, m and rad.
struct Errors {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  int count = 0;

  void add(const Pose& pose, const Pose& truth) {
    const Vector6d error = difference(truth, pose);
    squares += Eigen::Vector2d(error[0] * error[0], error[3] * error[3]);
    ++count;
  }
  Eigen::Vector2d mean() const { return (squares / count).cwiseSqrt(); }
};

/// A filter of a sweep of a second that begins exactly, with a mean acceleration of 2 and noise of
/// 0.3 on all axes.
DeviationFilter one_second() {
  DeviationFilter filter(Vector6d::Constant(0.3), Vector6d::Constant(2.0));
  filter.begin(0.5, Vector12d::Zero(), Matrix12d::Zero());
  return filter;
}

TEST(DeviationFilter, PredictsWithWhiteNoiseAboutAMeanAcceleration) {
  DeviationFilter filter = one_second();
  filter.predict(0.5);
  EXPECT_TRUE(test::near(filter.state().head<6>(), Vector6d::Constant(1.0), 1e-12));
  EXPECT_TRUE(test::near(filter.state().tail<6>(), Vector6d::Constant(2.0), 1e-12));
  EXPECT_NEAR(filter.covariance()(1, 1), 0.3 / 3.0, 1e-12);
  EXPECT_NEAR(filter.covariance()(1, 7), 0.3 / 2.0, 1e-12);
  EXPECT_NEAR(filter.covariance()(7, 7), 0.3, 1e-12);
  const SweepDeviations deviations = filter.deviations();
  EXPECT_TRUE(test::near(deviations.combined({1.0, 0.0, 0.0}), Vector6d::Zero(), 1e-12));
  EXPECT_TRUE(test::near(deviations.combined({0.0, 1.0, 0.0}), Vector6d::Constant(0.25), 1e-12));
  EXPECT_NEAR(deviations.covariance_of({0.0, 1.0, 0.0})(0, 0), 0.3 / 24.0, 1e-12);
}

// A measurement at the end improves the middle, but not a begin that is known exactly.
TEST(DeviationFilter, ImprovesEarlierDeviations) {
  DeviationFilter filter = one_second();
  filter.predict(0.5);
  const SweepDeviations before = filter.deviations();
  registration::NdtPart seen;
  seen.hessian = 1e6 * Matrix6d::Identity();
  seen.gradient = -seen.hessian * Vector6d::Constant(3.0);
  filter.measure(seen, 1.0);
  const SweepDeviations after = filter.deviations();
  EXPECT_NEAR(after.combined({0.0, 0.0, 1.0})[2], 3.0, 1e-4);
  EXPECT_GT(after.combined({0.0, 1.0, 0.0})[2], 0.5);
  EXPECT_LT(after.covariance_of({0.0, 1.0, 0.0})(2, 2),
            0.5 * before.covariance_of({0.0, 1.0, 0.0})(2, 2));
  EXPECT_NEAR(after.combined({1.0, 0.0, 0.0})[2], 0.0, 1e-12);
}

class SweepSmootherAt : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Stamps, SweepSmootherAt, ::testing::Values(-0.5, 0.0, 0.5));

// The stamp may be the begin, the middle or the end of the sweep.
TEST_P(SweepSmootherAt, IsBetterThanTheMatchIfTheMotionIsNotSteady) {
  const double seconds = GetParam() * kSweep;
  Drive drive(kSwaying);
  Errors alone, smoothed;
  for (int i = 0; i < 60; ++i) {
    drive.add(kSweep);
    if (i < 10) continue;
    const Pose truth = kSwaying.pose(drive.middle + seconds);
    alone.add(drive.of_match(seconds).T_map_sensor, truth);
    smoothed.add(drive.at(seconds).state.T_map_sensor, truth);
  }
  EXPECT_LT(smoothed.mean()[0], 0.6 * alone.mean()[0]);
  EXPECT_LT(smoothed.mean()[1], 0.3 * alone.mean()[1]);
}

TEST(SweepSmoother, LeavesASteadilyAcceleratedMotion) {
  Drive drive(kSteady);
  for (int i = 0; i < 20; ++i) drive.add(kSweep);
  const Pose truth = kSteady.pose(drive.middle - 0.5 * kSweep);
  EXPECT_TRUE(test::near(drive.at(-0.5 * kSweep).state.T_map_sensor, truth, 1e-3, 1e-3));
}

// The pose at the begin, with the twist and its change, leads through the rest of the sweep.
TEST(SweepSmoother, MotionFromTheStampLeadsThroughTheSweep) {
  Drive drive(kSwaying);
  for (int i = 0; i < 15; ++i) drive.add(kSweep);
  const MotionAtStamp begin = drive.at(-0.5 * kSweep);
  for (const double after : {0.5 * kSweep, kSweep}) {
    const Pose straight = moved(begin.state.T_map_sensor, begin.state.twist, after);
    const Pose pose = moved(straight, begin.acceleration, 0.5 * after * after);
    EXPECT_TRUE(test::near(pose, drive.at(after - 0.5 * kSweep).state.T_map_sensor, 3e-4, 3e-4));
  }
}

TEST(SweepSmoother, LeavesAMeasuredRotation) {
  Drive drive({[](double t) { return 0.5 * t; }, kSwaying.way});
  for (int i = 0; i < 15; ++i) drive.add(kSweep, turning_at(0.5));
  ASSERT_TRUE(drive.smoother.is_smoothed(drive.filter));
  const auto change_at = [&](double seconds) {
    return difference(drive.of_match(seconds).T_map_sensor, drive.at(seconds).state.T_map_sensor);
  };
  for (const double fraction : {-0.5, 0.0, 0.5}) {
    EXPECT_LT(change_at(fraction * kSweep).tail<3>().norm(), 1e-9) << fraction;
  }
  EXPECT_GT(change_at(-0.5 * kSweep).head<3>().norm(), 1e-4);
  const Matrix12d ones = Matrix12d::Ones();
  const Matrix12d measured = without_smoothed_twist(ones, true);
  EXPECT_EQ(measured(11, 11), 1.0);
  EXPECT_EQ(measured.middleRows(6, 3).norm(), 0.0);
  EXPECT_EQ(without_smoothed_twist(ones, false).bottomRows(6).norm(), 0.0);
}

/// Turns steadily for 15 sweeps while a gyro measures this rate (rad/s).
Drive turned_by_gyro(double rate, bool measured) {
  const Motion turning{[](double t) { return 0.5 * t; }, [](double t) { return t; }};
  Drive drive(turning);
  const auto turned = measured ? std::optional(turning_at(rate)) : std::nullopt;
  for (int i = 0; i < 15; ++i) drive.add(kSweep, turned);
  return drive;
}

TEST(SweepSmoother, SaysHowFarAGyroContradictsIt) {
  for (const bool measured : {false, true}) {
    const auto contradiction = turned_by_gyro(0.5, measured).contradiction_to(0.5);
    ASSERT_TRUE(contradiction);
    EXPECT_LT(*contradiction, 1.0) << measured;
  }
  EXPECT_GT(turned_by_gyro(0.5, false).contradiction_to(-0.5).value(), 10.0);
}

/// Contradiction at a jump of the turn by 2 mrad between two sweeps, this number of sweeps after
/// the first one, to a gyro that does not measure it.
double contradiction_at_jump(int sweeps) {
  const double jump = (sweeps + 0.5) * kSweep;
  Drive drive({[=](double t) { return t < jump ? 0.0 : 2e-3; }, [](double t) { return t; }});
  for (int i = 0; i <= sweeps; ++i) drive.add(kSweep, turning_at(0.0));
  return drive.contradiction_to(0.0).value_or(0.0);
}

// The previous sweep does not make a measured rotation surer than its match is.
TEST(SweepSmoother, TheContradictionIsThatOfTwoMatches) {
  const double of_matches = contradiction_at_jump(2);  // the sweep before is not smoothed
  EXPECT_GT(of_matches, 0.1);
  EXPECT_NEAR(contradiction_at_jump(6), of_matches, 0.05 * of_matches);
}

// While the sensor does not turn, any gyro seems to be right.
TEST(SweepSmoother, SaysNothingOfAGyroThatDoesNotTurn) {
  const Motion straight{[](double) { return 0.0; }, [](double t) { return t; }};
  Drive drive(straight);
  for (int i = 0; i < 15; ++i) drive.add(kSweep);
  EXPECT_FALSE(drive.contradiction_to(0.0));
}

// The sensor sways, but the gyro measures no rotation.
TEST(SweepSmoother, LeavesSweepsWithAWrongRotation) {
  Drive drive(kSwaying);
  int contradicted = 0;
  for (int i = 0; i < 40; ++i) {
    drive.add(kSweep, turning_at(0.0));
    const auto contradiction = drive.contradiction_to(0.0);
    if (!contradiction || *contradiction < 4.0) continue;
    ++contradicted;
    EXPECT_FALSE(drive.smoother.is_smoothed(drive.filter));
  }
  EXPECT_GT(contradicted, 5);
}

TEST(SweepSmoother, LeavesSweepsThatDoNotTouch) {
  Drive drive(kSwaying);
  for (int i = 0; i < 15; ++i) drive.add(0.2);
  EXPECT_FALSE(drive.smoother.is_smoothed(drive.filter));
  EXPECT_EQ(drive.at(-0.05).state.T_map_sensor.translation,
            drive.of_match(-0.05).T_map_sensor.translation);
  for (int i = 0; i < 2; ++i) drive.add(kSweep);
  EXPECT_TRUE(drive.smoother.is_smoothed(drive.filter));
}

TEST(SweepSmoother, LeavesSweepsWithAnOpenDirection) {
  Drive drive(kSwaying);
  for (int i = 0; i < 15; ++i) drive.add(kSweep);
  drive.found.degenerate_directions = {Eigen::Vector3d::UnitX()};
  drive.smoother.add(drive.found, drive.filter, kSweep);
  EXPECT_FALSE(drive.smoother.is_smoothed(drive.filter));
}

// Nothing is known of a scan that was not matched.
TEST(SweepSmoother, LeavesPredictions) {
  Drive drive(kSwaying);
  for (int i = 0; i < 15; ++i) drive.add(kSweep);
  drive.filter.predict(kSweep);
  EXPECT_FALSE(drive.smoother.is_smoothed(drive.filter));
  EXPECT_EQ(drive.at(0.0).state.T_map_sensor.translation,
            drive.filter.state().T_map_sensor.translation);
}

// However much the sensor shakes, the covariance is as large as the errors.
TEST(SweepSmoother, CovarianceHasTheSizeOfTheErrors) {
  for (const double amplitude : {0.02, 0.1, 0.3}) {
    const Motion shaking{
        [=](double t) { return amplitude * std::sin(15.0 * t) * std::cos(4.0 * t); },
        [=](double t) { return t + 0.3 * amplitude * std::sin(14.0 * t) * std::cos(5.0 * t); }};
    Drive drive(shaking);
    double linear = 0.0, angular = 0.0;
    constexpr int kSweeps = 300;
    for (int i = 0; i < kSweeps; ++i) {
      drive.add(kSweep);
      if (i < 20) continue;
      const MotionAtStamp begin = drive.at(-0.5 * kSweep);
      const Vector6d error =
          difference(shaking.pose(drive.middle - 0.5 * kSweep), begin.state.T_map_sensor);
      linear += error.head<3>().squaredNorm() / begin.covariance.topLeftCorner<3, 3>().trace();
      angular += error.tail<3>().squaredNorm() / begin.covariance.bottomRightCorner<3, 3>().trace();
    }
    EXPECT_GT(linear / (kSweeps - 20), 0.3) << amplitude;
    EXPECT_LT(linear / (kSweeps - 20), 3.0) << amplitude;
    EXPECT_GT(angular / (kSweeps - 20), 0.1) << amplitude;
    EXPECT_LT(angular / (kSweeps - 20), 3.0) << amplitude;
  }
}

/// Error of the way at the begin of sweeps whose turn is measured, m.
double error_with_measured_turn(double lever) {
  Drive drive({[](double t) { return 0.5 * t; }, kSwaying.way});
  drive.lever = lever;
  Errors errors;
  for (int i = 0; i < 60; ++i) {
    drive.add(kSweep, turning_at(0.5));
    if (i < 10) continue;
    errors.add(drive.at(-0.5 * kSweep).state.T_map_sensor,
               drive.motion.pose(drive.middle - 0.5 * kSweep));
  }
  return errors.mean()[0];
}

// If the turn is known, what the slices see of way and turn together is the way, with five times
// the noise.
TEST(SweepSmoother, UsesTheMeasuredRotationForTheTranslation) {
  EXPECT_LT(error_with_measured_turn(5.0), 5.0 * error_with_measured_turn(0.0));
}

TEST(SweepSmoother, HasASmallerCovarianceForASteadyMotionThanForASwayingOne) {
  Drive steady({[](double) { return 0.0; }, [](double t) { return 5.0 * t; }});
  Drive swaying(kSwaying);
  for (int i = 0; i < 60; ++i) {
    steady.add(kSweep);
    swaying.add(kSweep);
  }
  const auto sigma = [](const Drive& drive) {
    return std::sqrt(drive.smoother.usual_covariance().diagonal().maxCoeff());
  };
  EXPECT_LT(sigma(steady), 0.3 * sigma(swaying));
}

// A gyro makes the rotation of each sweep uniform: its rate jumps between the sweeps.
TEST(SweepSmoother, AcceptsAMeasuredRateThatJumps) {
  const auto rate_of = [](int sweep) { return sweep % 2 == 0 ? 1.0 : -0.5; };
  const auto turn = [&](double t) {
    const double sweeps = t / kSweep + 0.5;
    const int whole = static_cast<int>(std::floor(sweeps));
    double sum = 0.0;
    for (int k = 0; k < whole; ++k) sum += rate_of(k) * kSweep;
    return sum + rate_of(whole) * (sweeps - whole) * kSweep;
  };
  Drive drive({turn, [](double t) { return t; }});
  for (int sweep = 1; sweep < 30; ++sweep) {
    MeasuredTurning turning = turning_at(rate_of(sweep));
    turning.between.x() = 0.5 * (rate_of(sweep - 1) + rate_of(sweep));
    drive.add(kSweep, turning);
    EXPECT_LT(drive.contradiction_to(rate_of(sweep)).value_or(0.0), 1.0) << sweep;
  }
  EXPECT_TRUE(drive.smoother.is_smoothed(drive.filter));
}

TEST(SweepSmoother, KeepsNothingOfThePreviousDrive) {
  Drive drive(kSwaying);
  for (int i = 0; i < 15; ++i) drive.add(kSweep);
  EXPECT_GT(drive.smoother.usual_covariance().norm(), 0.0);
  drive.smoother.reset();
  EXPECT_EQ(drive.smoother.usual_covariance().norm(), 0.0);
  EXPECT_FALSE(drive.smoother.is_smoothed(drive.filter));
}

}  // namespace
}  // namespace lidar_mapping::front_end
