// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "motion/gyro_validator.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kSweep = 0.1;  // s

/// A sensor that is shaken: the mean rate of its sweep `i`, rad/s.
Eigen::Vector3d true_rate(int i) {
  return {0.8 * std::sin(0.5 * i), 0.6 * std::cos(0.4 * i), 0.5 * std::sin(0.3 * i)};
}

MotionPrior turning_at(const Eigen::Vector3d& rate) {
  MotionPrior prior;
  prior.angular_velocity = rate;
  return prior;
}

/// Shows GyroValidator so many sweeps, as a gyro sees them and as they are matched; without a gyro
/// the last turning is expected to go on.
template <typename Gyro>
void ride(int sweeps, const Gyro& gyro, GyroValidator& validator) {
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  Eigen::Quaterniond turn = last;
  for (int i = 0; i < sweeps; ++i) {
    validator.add(turning_at(gyro(true_rate(i))), kSweep, kSweep);
    const Eigen::Quaterniond without_gyro = last * turn;
    turn = exp_so3(0.5 * kSweep * true_rate(i - 1)) * exp_so3(0.5 * kSweep * true_rate(i));
    validator.update(last, without_gyro, last * turn);
    last = last * turn;
  }
}

const auto kExact = [](const Eigen::Vector3d& rate) { return rate; };

TEST(GyroValidator, LearnsTheBias) {
  const Eigen::Vector3d bias(0.02, -0.03, 0.01);
  GyroValidator validator;
  ride(
      200, [&](const Eigen::Vector3d& rate) { return Eigen::Vector3d(rate + bias); }, validator);
  ASSERT_TRUE(validator.turning());
  EXPECT_TRUE(test::near(validator.turning()->within, true_rate(199), 2e-3));
  EXPECT_FALSE(validator.is_distrusted());
}

TEST(GyroValidator, ComputesTheRotationBetweenTheMiddlesOfSweeps) {
  GyroValidator validator;
  ride(20, kExact, validator);
  const Eigen::Quaterniond turn =
      exp_so3(0.5 * kSweep * true_rate(18)) * exp_so3(0.5 * kSweep * true_rate(19));
  ASSERT_TRUE(validator.turning());
  EXPECT_LT(rotation_angle(turn.conjugate() * exp_so3(kSweep * validator.turning()->between)),
            1e-4);
}

// Scale and axes of cheap gyros have errors. With a smaller sigma they would rotate the map.
TEST(GyroValidator, HasALowerBoundOfTheSigma) {
  GyroValidator validator;
  ride(100, kExact, validator);
  EXPECT_DOUBLE_EQ(validator.turning()->sigma, 0.02);
}

TEST(GyroValidator, AdaptsTheSigmaToTheError) {
  GyroValidator validator;
  ride(
      100, [](const Eigen::Vector3d& rate) { return Eigen::Vector3d(1.2 * rate); }, validator);
  ASSERT_TRUE(validator.turning());
  EXPECT_GT(validator.turning()->sigma, 0.04);
  EXPECT_LT(validator.turning()->sigma, 0.3);
}

TEST(GyroValidator, DoesNotUseTheGyroAtFirst) {
  GyroValidator validator;
  ride(4, kExact, validator);
  EXPECT_FALSE(validator.turning());
  EXPECT_FALSE(validator.is_distrusted());
}

TEST(GyroValidator, DoesNotInterpolateBetweenSeparatedSweeps) {
  GyroValidator validator;
  ride(20, kExact, validator);
  validator.add(turning_at(true_rate(20)), 2.0 * kSweep, kSweep);
  EXPECT_FALSE(validator.turning());
  validator.add(turning_at(true_rate(21)), kSweep, kSweep);
  EXPECT_TRUE(validator.turning());
  validator.add({}, kSweep, kSweep);
  EXPECT_FALSE(validator.turning());
}

// Wrong units, wrong axes, and right again.
TEST(GyroValidator, DoesNotUseAWrongGyro) {
  const auto degrees = [](const Eigen::Vector3d& rate) { return Eigen::Vector3d(57.3 * rate); };
  const auto turned = [](const Eigen::Vector3d& rate) {
    return Eigen::Vector3d(-rate.y(), rate.x(), -rate.z());
  };
  MotionPrior prior;
  prior.angular_velocity = Eigen::Vector3d::Zero();
  for (const auto& wrong : {std::function<Eigen::Vector3d(const Eigen::Vector3d&)>(degrees),
                            std::function<Eigen::Vector3d(const Eigen::Vector3d&)>(turned)}) {
    GyroValidator validator;
    ride(100, wrong, validator);
    EXPECT_TRUE(validator.is_distrusted());
    EXPECT_FALSE(validator.turning());
    EXPECT_FALSE(validator.remaining_prior(prior).angular_velocity);
    ride(200, kExact, validator);
    EXPECT_FALSE(validator.is_distrusted());
  }
}

// Degrees instead of radians after a rest, during which no match can show that the gyro is wrong.
TEST(GyroValidator, RejectsRatesFarBeyondConfirmedOnes) {
  GyroValidator validator;
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  for (int i = 0; i < 30; ++i) {
    validator.add(turning_at(Eigen::Vector3d::Zero()), kSweep, kSweep);
    validator.update(level, level, level);
  }
  EXPECT_FALSE(validator.is_distrusted());
  EXPECT_TRUE(validator.accepts(turning_at({0.0, 0.0, 0.5})));
  EXPECT_FALSE(validator.accepts(turning_at({0.0, 0.0, 20.0})));
  MotionPrior bent = turning_at({0.0, 0.0, 0.5});
  bent.uneven_turning = UnevenTurning{-0.1, 0.05, {level, exp_so3({0.3, 0.0, 0.0}), level}};
  EXPECT_FALSE(validator.accepts(bent));
  validator.add(bent, kSweep, kSweep);
  EXPECT_FALSE(validator.turning());
  EXPECT_FALSE(validator.remaining_prior(bent).angular_velocity);
  ride(10, kExact, validator);
  EXPECT_TRUE(validator.accepts(turning_at({0.0, 0.0, 5.0})))
      << "as fast as a sensor is turned by hand";
}

// The mean rate of a sweep says how far it turned, but not that it did so uniformly.
TEST(GyroValidator, KnowsWhetherTheSweepTurnsUniformly) {
  GyroValidator validator;
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  for (int i = 0; i < 30; ++i) {
    validator.add(turning_at(Eigen::Vector3d::Zero()), kSweep, kSweep);
    validator.update(level, level, level);
  }
  MotionPrior prior = turning_at({0.0, 0.0, 0.1});
  validator.add(prior, kSweep, kSweep);
  ASSERT_TRUE(validator.turning());
  EXPECT_FALSE(validator.turning()->uniform);
  prior.uneven_turning = UnevenTurning{-0.1, 0.1, {level, level}};
  validator.add(prior, kSweep, kSweep);
  EXPECT_TRUE(validator.turning()->uniform) << "the rest was removed";
}

// A rotation that the filter has received from turning() is not measured a second time.
TEST(GyroValidator, IsNotAppliedTwice) {
  MotionPrior prior;
  prior.angular_velocity = Eigen::Vector3d::Zero();
  GyroValidator validator;
  EXPECT_TRUE(validator.remaining_prior(prior).angular_velocity);
  ride(20, kExact, validator);
  EXPECT_FALSE(validator.remaining_prior(prior).angular_velocity);
}

TEST(MotionFilter, UsesTheMeasuredRotation) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 1.0, 1.0);
  filter.correct({Pose{}, Vector6d::Zero()}, filter.covariance());
  const MeasuredTurning turning{{0.0, 0.0, 1.0}, {0.0, 0.0, 2.0}, 0.02};
  filter.predict(kSweep, turning);
  EXPECT_LT(
      rotation_angle(filter.state().T_map_sensor.rotation.conjugate() * exp_so3({0.0, 0.0, 0.1})),
      1e-9);
  EXPECT_TRUE(test::near(filter.state().twist.tail<3>(), turning.within, 1e-9));
  EXPECT_NEAR(std::sqrt(filter.covariance()(5, 5)), 0.02 * kSweep, 1e-4);
  EXPECT_NEAR(std::sqrt(filter.covariance()(11, 11)), 0.02, 1e-4);
  EXPECT_LT(rotation_angle(filter.forecast_state().T_map_sensor.rotation), 1e-9);
}

// A gyro may be missing in the next sweep. So the acceleration is learned as if there were none.
TEST(MotionFilter, LearnsAngularAccelerationDespiteTheGyro) {
  const auto spread = [](bool with_gyro) {
    MotionFilter filter(10.0, 50.0);
    filter.reset(Pose{}, 1.0, 1.0);
    MotionState truth{Pose{}, Vector6d::Zero()};
    for (int i = 0; i < 20; ++i) {
      filter.predict(kSweep);
      truth.twist[5] = i % 2 == 0 ? 1.0 : -1.0;
      truth.T_map_sensor.rotation = exp_so3({0.0, 0.0, 0.02 * truth.twist[5]});
      if (with_gyro) filter.measure_rate(truth.twist.tail<3>(), 0.1);
      filter.correct(truth, 1e-6 * Matrix12d::Identity());
    }
    filter.predict(kSweep);
    return std::sqrt(filter.covariance()(11, 11));
  };
  EXPECT_GT(spread(true), 0.8 * spread(false));
}

// On legs, which shake the sensor, a wrong gyro predicts no worse than none.
TEST(GyroValidator, DistrustsAGyroThatTheTimeSlicesContradict) {
  GyroValidator validator;
  ride(20, kExact, validator);
  validator.add_contradiction(100.0);
  EXPECT_FALSE(validator.is_distrusted()) << "one match that is off";
  for (int i = 0; i < 10; ++i) validator.add_contradiction(10.0);
  EXPECT_TRUE(validator.is_distrusted());
  EXPECT_FALSE(validator.accepts(turning_at({0.1, 0.0, 0.0})));
  for (int i = 0; i < 10; ++i) validator.add_contradiction(0.5);
  EXPECT_FALSE(validator.is_distrusted()) << "it is right again";
}

TEST(GyroValidator, GivesTheRateWithoutTheBias) {
  const Eigen::Vector3d bias(0.02, -0.03, 0.01);
  GyroValidator validator;
  EXPECT_FALSE(validator.rate());
  ride(
      200, [&](const Eigen::Vector3d& rate) { return Eigen::Vector3d(rate + bias); }, validator);
  ASSERT_TRUE(validator.rate());
  EXPECT_TRUE(test::near(*validator.rate(), true_rate(199), 2e-3));
}

}  // namespace
}  // namespace lidar_mapping::front_end
