// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "motion/motion_filter.hpp"
#include "motion/twist_predictor.hpp"
#include "motion/velocity_validator.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

Pose turned(double angle) { return {exp_so3({0.0, 0.0, angle}), Eigen::Vector3d::Zero()}; }

// The prediction continues with the velocity for the time between the stamps.
TEST(MotionFilter, PredictsWithConstantVelocityOverRealTime) {
  Vector6d twist;
  twist << 30.0, 0.0, 0.0, 0.0, 0.0, 0.3;
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 1.0, 1.0);
  filter.correct({Pose{}, twist}, filter.covariance());
  filter.predict(0.1);
  filter.predict(0.25);
  EXPECT_TRUE(test::near(filter.state().T_map_sensor, moved(Pose{}, twist, 0.35), 1e-9));
}

/// Where a car is that turns in ever faster, `seconds` after it drove straight.
Pose turning_in(double seconds) {
  Vector6d mean_twist;
  mean_twist << 10.0, 0.0, 0.0, 0.0, 0.0, 0.5 * seconds;
  return moved(Pose{}, mean_twist, seconds);
}

/// What a sweep of a tenth of a second finds there with a twist that is taken to be constant.
MotionState fitted_turning_in(double seconds) {
  Vector6d twist;
  twist << 10.0, 0.0, 0.0, 0.0, 0.0, seconds;
  Vector6d bend = Vector6d::Zero();
  bend[5] = 0.1 * 0.1 / 24.0;
  return {moved(turning_in(seconds), bend, 1.0), twist};
}

TEST(MotionFilter, TwistChangesWithinASweep) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(turning_in(0.0), 15.0, 1.0);
  EXPECT_EQ(filter.acceleration().norm(), 0.0);
  for (const double seconds : {0.1, 0.2}) {
    filter.predict(0.1);
    filter.correct(fitted_turning_in(seconds), filter.covariance());
  }
  EXPECT_NEAR(filter.acceleration()[5], 1.0, 0.01);
  const MotionState at_stamp =
      steadily_accelerated(filter.state(), filter.acceleration(), 0.1, -0.05);
  EXPECT_LT(rotation_angle(at_stamp.T_map_sensor.rotation.conjugate() * turning_in(0.15).rotation),
            1e-5);
  EXPECT_NEAR(at_stamp.twist[5], 0.15, 1e-3);
  const Pose straight = moved(filter.state().T_map_sensor, filter.state().twist, -0.05);
  EXPECT_GT(rotation_angle(straight.rotation.conjugate() * turning_in(0.15).rotation), 5e-4);
  filter.predict(0.1);
  EXPECT_EQ(filter.acceleration().norm(), 0.0) << "of a prediction nothing is known";
}

TEST(MotionFilter, IgnoresJumpsAsAccelerations) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 15.0, 1.0);
  filter.predict(0.1);
  filter.correct({turning_in(1.0), Vector6d::Zero()}, filter.covariance());
  EXPECT_EQ(filter.acceleration().norm(), 0.0);
}

// A measured speed forward moves the prediction forward.
TEST(MotionFilter, AppliesTheMeasuredVelocityInTheRightAxes) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(turned(0.5), 15.0, 1.0);
  filter.predict(0.1);
  filter.measure_velocity({10.0, 0.0, 0.0}, 0.1);
  const Eigen::Vector3d expected(std::cos(0.5), std::sin(0.5), 0.0);
  EXPECT_TRUE(test::near(filter.state().T_map_sensor.translation, expected, 0.05));
  EXPECT_NEAR(filter.state().twist[0], 10.0, 0.1);
}

TEST(MotionFilter, CovarianceStaysValid) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 15.0, 1.0);
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> step(0.01, 2.0);
  for (int i = 0; i < 200; ++i) {
    filter.predict(step(engine));
    filter.measure_rate({0.1, 0.0, 0.2}, 0.1);
    filter.measure_velocity({1.8, 2.4, 0.0}, 0.1);
    const Covariance6 covariance =
        pose_covariance(filter.covariance(), filter.state().twist, -0.05);
    ASSERT_TRUE(is_valid_covariance(0.5 * (covariance + covariance.transpose()))) << i;
  }
}

// The first scans of a drive are matched a second time, from the latest to the first.
TEST(MotionFilter, LearnsAccelerationsBackwardsInTimeAsForwards) {
  const auto rate_sigma = [](double seconds) {
    MotionFilter filter(10.0, 50.0);
    filter.reset(Pose{}, 1.0, 1.0);
    for (int i = 1; i <= 20; ++i) {
      filter.predict(seconds);
      const double phase = 10.0 * seconds * i;
      MotionState swaying{turned(0.1 * std::sin(phase)), Vector6d::Zero()};
      swaying.twist[5] = std::cos(phase);
      filter.correct(swaying, 1e-6 * Matrix12d::Identity());
    }
    filter.predict(seconds);
    return std::sqrt(filter.covariance()(11, 11));
  };
  EXPECT_GT(rate_sigma(0.1), 0.2) << "or this test shows nothing";
  EXPECT_NEAR(rate_sigma(-0.1), rate_sigma(0.1), 1e-6);
}

TEST(MotionFilter, TreatsTheRotationAsNotMeasuredAfterARestart) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 1.0, 1.0);
  const Eigen::Vector3d rate(0.0, 0.0, 0.1);
  filter.predict(0.1, MeasuredTurning{rate, rate, 0.01});
  ASSERT_TRUE(filter.is_rotation_measured());
  MotionFilter restarted = filter;
  restarted.restart(filter.state(), filter.covariance());
  EXPECT_FALSE(restarted.is_rotation_measured());
  filter.reset(Pose{}, 1.0, 1.0);
  EXPECT_FALSE(filter.is_rotation_measured());
}

// The smoothing of a sweep takes a measured rotation as exact at every instant.
TEST(MotionFilter, TreatsTheRotationAsNotMeasuredWithinASweepThatIsUneven) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 1.0, 1.0);
  const Eigen::Vector3d rate(0.0, 0.0, 0.1);
  filter.predict(0.1, MeasuredTurning{rate, rate, 0.01, false});
  EXPECT_FALSE(filter.is_rotation_measured());
  EXPECT_EQ(filter.state().twist.tail<3>(), rate);
}

/// A vehicle that brakes from 14 m/s at 1.8 m/s^2 and pitches, after six seconds.
MotionFilter braking_filter() {
  const Matrix12d covariance = Vector12d::Constant(1e-5).asDiagonal().toDenseMatrix();
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose::Identity(), 15.0, 1.0);
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    Vector6d twist = Vector6d::Zero();
    twist[0] = 14.0 - 1.8 * t;
    twist[4] = 0.02;
    const Pose pose{exp_so3({0.0, 0.02 * t, 0.0}), {14.0 * t - 0.9 * t * t, 0.0, 0.0}};
    if (i > 0) filter.predict(0.1);
    filter.correct({pose, twist}, covariance);
  }
  return filter;
}

// A pause of the recording, or a clock that was set: nothing goes on for so long. The pose stays
// where a new map can begin, and the covariance has an inverse.
TEST(MotionFilter, ContinuesAMotionForSecondsOnly) {
  for (const double gap : {60.0, 600.0, 1.7e9}) {
    MotionFilter filter = braking_filter();
    const MotionState before = filter.state();
    filter.predict(gap);
    const Pose step = before.T_map_sensor.inverse() * filter.state().T_map_sensor;
    EXPECT_GT(step.translation.x(), 5.0) << gap;
    EXPECT_LT(step.translation.norm(), 25.0) << gap;
    EXPECT_LT(rotation_angle(step.rotation), 0.035) << gap;
    EXPECT_GT(filter.state().twist[0], 0.0) << gap << ": it does not reverse";
    EXPECT_GT(filter.covariance()(0, 0), 1e4) << gap;
    EXPECT_LT(filter.covariance()(0, 0), 1e13) << gap;
    const Matrix12d product = filter.covariance() * filter.belief().information;
    EXPECT_LT((product - Matrix12d::Identity()).norm(), 1e-3) << gap;
  }
}

// A velocity that is measured behind a gap does not tell of the whole gap.
TEST(MotionFilter, MovesByMeasuredVelocitiesForSecondsOnly) {
  MotionFilter filter = braking_filter();
  const MotionState before = filter.state();
  filter.predict(600.0);
  filter.measure_velocity({20.0, 0.0, 0.0}, 0.1);
  filter.measure_rate({0.0, 0.1, 0.0}, 0.1);
  const Pose step = before.T_map_sensor.inverse() * filter.state().T_map_sensor;
  EXPECT_LT(step.translation.norm(), 60.0);
  EXPECT_LT(rotation_angle(step.rotation), 0.1);
  EXPECT_NEAR(filter.state().twist[0], 20.0, 0.2);
}

TEST(MotionFilter, ContinuesNoMotionOverAGapBetweenMatches) {
  Vector6d noise = Vector6d::Zero();
  noise[0] = 0.01;
  const MotionState at_rest{Pose::Identity(), noise};
  EXPECT_LT(gap_between({at_rest, 1e9}, at_rest).norm(), 0.11);
}

TEST(Continued, IsAsMovedForASecond) {
  Vector6d twist;
  twist << 12.0, -0.5, 0.3, 0.2, -0.4, 0.5;
  for (const double seconds : {-1.0, -0.1, 0.0, 0.1, 1.0})
    EXPECT_EQ(continued(turned(0.7), twist, seconds).matrix(),
              moved(turned(0.7), twist, seconds).matrix());
  const Pose of_hour = continued(turned(0.7), twist, 3600.0);
  EXPECT_TRUE(test::near(of_hour, continued(turned(0.7), twist, 5.0), 1e-9));
  const Pose before = continued(turned(0.7), twist, -3600.0);
  EXPECT_TRUE(test::near(before, continued(turned(0.7), twist, -5.0), 1e-9));
}

TEST(TwistBetween, IsTheInverseOfMoved) {
  Vector6d twist;
  twist << 12.0, -0.5, 0.3, 0.2, -0.4, 1.5;
  const Pose a = moved(turned(0.7), twist, 3.0);
  EXPECT_TRUE(test::near(twist_between(a, moved(a, twist, 0.4), 0.4), twist, 1e-9));
}

TEST(TwistPredictor, PrefersTheBetterPredictor) {
  std::mt19937 engine(5);
  std::normal_distribution<double> jitter(0.0, 1.0);
  const Vector6d walk = Vector6d::Constant(1.3);
  TwistPredictor of_a_walk(10.0);
  TwistPredictor of_a_car(10.0);
  for (int i = 0; i < 200; ++i) {
    const Vector6d gait = Vector6d::NullaryExpr([&](Eigen::Index) { return jitter(engine); });
    of_a_walk.update(walk + 0.05 * gait, walk + gait, 0.1);
    const Vector6d speeding = Vector6d::Constant(0.1 * i);
    of_a_car.update(speeding, speeding + Vector6d::Constant(0.05), 0.1);
  }
  EXPECT_TRUE(test::near(of_a_walk.next(0.1), walk, 0.3));
  EXPECT_TRUE(test::near(of_a_car.next(0.1).tail<3>(), Vector6d::Constant(19.95).tail<3>(), 0.05));
  EXPECT_TRUE(test::near(of_a_car.next(0.1).head<3>(), Vector6d::Constant(20.0).head<3>(), 1e-6));
}

TEST(TwistPredictor, ContinuesAnAccelerationForTheNextStep) {
  TwistPredictor forecast(10.0);
  const double acceleration = -2.0;
  double time = 0.0;
  for (int step = 0; step < 100; ++step) {
    const double seconds = step % 3 == 0 ? 0.2 : 0.1;
    Vector6d mean_twist = Vector6d::Zero();
    mean_twist[0] = 30.0 + acceleration * (time + 0.5 * seconds);
    mean_twist[2] = step % 2 == 0 ? 0.1 : -0.1;
    Vector6d sweep_twist = mean_twist;
    time += seconds;
    sweep_twist[0] = 30.0 + acceleration * time;
    forecast.update(mean_twist, sweep_twist, seconds);
  }
  EXPECT_NEAR(forecast.next(0.3)[0], 30.0 + acceleration * (time + 0.15), 1e-6);
  EXPECT_NEAR(forecast.at_end_of_next(0.3)[0], 30.0 + acceleration * (time + 0.3), 1e-6);
  // What goes up and down from step to step is not carried on.
  EXPECT_EQ(forecast.at_end_of_next(0.3)[2], forecast.next(0.3)[2]);
}

TEST(TwistPredictor, IgnoresAJumpOfThePose) {
  TwistPredictor forecast(10.0);
  Vector6d twist = Vector6d::Zero();
  for (int step = 0; step < 30; ++step) {
    twist[0] = 0.2 * step;
    forecast.update(twist, twist, 0.1);
  }
  EXPECT_GT(forecast.at_end_of_next(0.1)[0] - forecast.next(0.1)[0], 0.09);
  twist[0] += 3.0;
  forecast.update(twist, twist, 0.1);
  EXPECT_EQ(forecast.at_end_of_next(0.1)[0], forecast.next(0.1)[0]);
}

// A prediction that lags behind pulls each pose back while the vehicle speeds up and ahead while it
// brakes. Both remain in the map. Streets become longer, as the points constrain less at speed.
TEST(MotionFilter, DoesNotLagBehindABrakingVehicle) {
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  constexpr double kStep = 0.1, kAcceleration = -1.8;
  const Matrix12d covariance = Vector12d::Constant(1e-5).asDiagonal().toDenseMatrix();
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose::Identity(), 15.0, 1.0);
  std::vector<double> behind;
  for (int i = 0; i < 60; ++i) {
    const double t = kStep * i;
    Vector6d twist = Vector6d::Zero();
    twist[0] = 14.0 + kAcceleration * t;
    Pose pose;
    pose.translation.x() = 14.0 * t + 0.5 * kAcceleration * t * t + noise(engine);
    if (i > 0) filter.predict(kStep);
    if (i > 20)
      behind.push_back(filter.state().T_map_sensor.translation.x() - pose.translation.x());
    filter.correct({pose, twist}, covariance);
  }
  const double mean =
      std::accumulate(behind.begin(), behind.end(), 0.0) / static_cast<double>(behind.size());
  EXPECT_LT(std::abs(mean), 0.003) << "0.011 with a constant twist";
}

TEST(TwistPredictor, DistinguishesASteadyAccelerationFromAGait) {
  TwistPredictor forecast(10.0);
  for (int step = 0; step < 100; ++step) {
    // Forward ever faster, up and down from step to step, and not at all about z.
    Vector6d mean_twist = Vector6d::Zero();
    mean_twist[0] = 0.1 * step;
    Vector6d sweep_twist = mean_twist;
    sweep_twist[0] += 0.05;
    sweep_twist[2] = step % 2 == 0 ? 0.1 : -0.1;
    forecast.update(mean_twist, sweep_twist, 0.1);
  }
  EXPECT_NEAR(forecast.change_persistence()[0], 1.0, 1e-9);
  EXPECT_EQ(forecast.change_persistence()[2], 0.0);
  EXPECT_EQ(forecast.change_persistence()[5], 0.0);
}

TEST(VelocityValidator, LearnsScaleAndAccuracyOfTheVelocity) {
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.1);
  VelocityValidator wheels;
  VelocityValidator dead;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d velocity(10.0, 0.0, 0.0);
    wheels.update(1.02 * velocity + Eigen::Vector3d(noise(engine), noise(engine), 0.0), velocity);
    dead.update(Eigen::Vector3d::Zero(), velocity);
  }
  EXPECT_NEAR(wheels.corrected({10.2, 0.0, 0.0}).x(), 10.0, 0.03);
  EXPECT_NEAR(wheels.usual_sigma(), 0.08, 0.03);
  EXPECT_GT(dead.cautious_sigma(0.0), 5.0);
  EXPECT_GT(dead.usual_sigma(), 3.0);
}

TEST(VelocityValidator, DistrustsOtherUnitsAndSignsAndASensorThatDoesNotMeasure) {
  const Eigen::Vector3d velocity(5.0, 0.0, 0.0);
  const auto is_distrusted = [&](double factor, int matches) {
    VelocityValidator validator;
    for (int i = 0; i < matches; ++i) validator.update(factor * velocity, velocity);
    return validator.is_distrusted();
  };
  for (const double factor : {3.6, -1.0, 0.0}) {
    EXPECT_TRUE(is_distrusted(factor, 20)) << factor;
    EXPECT_FALSE(is_distrusted(factor, 1)) << factor << ": one match may be wrong itself";
  }
  for (const double factor : {0.8, 1.0, 1.3}) EXPECT_FALSE(is_distrusted(factor, 200)) << factor;
}

TEST(VelocityValidator, TrustsAVelocityAgainThatAgreesAgain) {
  const Eigen::Vector3d velocity(5.0, 0.0, 0.0);
  VelocityValidator validator;
  for (int i = 0; i < 20; ++i) validator.update(Eigen::Vector3d::Zero(), velocity);
  EXPECT_TRUE(validator.is_distrusted());
  for (int i = 0; i < 200; ++i) validator.update(velocity, velocity);
  EXPECT_FALSE(validator.is_distrusted());
}

TEST(VelocityValidator, SaysNothingAtRest) {
  VelocityValidator validator;
  for (int i = 0; i < 200; ++i) validator.update({0.1, 0.0, 0.0}, Eigen::Vector3d::Zero());
  EXPECT_FALSE(validator.is_distrusted());
}

// Long chains of motions stay rotations.
TEST(Moved, StaysARotationOverAHundredThousandSteps) {
  Vector6d twist;
  twist << 10.0, 0.0, 0.0, 0.01, -0.02, 0.3;
  Pose pose;
  for (int i = 0; i < 100000; ++i) pose = moved(pose, twist, 0.1);
  EXPECT_NEAR(pose.rotation_matrix().determinant(), 1.0, 1e-9);
}

}  // namespace
}  // namespace lidar_mapping::front_end
