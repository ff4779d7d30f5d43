// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "motion/deviation_filter.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

using test::near;

constexpr double kHalf = 0.05;  // s, half of a sweep at 10 Hz

Vector6d six(double a, double b, double c, double d, double e, double f) {
  return (Vector6d() << a, b, c, d, e, f).finished();
}

const Vector6d kNoise = six(1.0, 2.0, 3.0, 0.1, 0.2, 0.3);
const Vector6d kAcceleration = six(0.5, -1.0, 0.2, 0.3, 0.0, -0.4);

Vector12d start_state() {
  Vector12d state;
  state << six(0.01, 0.02, -0.01, 0.001, 0.002, 0.003), six(0.1, -0.2, 0.3, 0.01, 0.02, -0.03);
  return state;
}

/// Deviation and its change are correlated, as they are at the end of the sweep before.
Matrix12d start_covariance() {
  Matrix12d P = Matrix12d::Zero();
  P.diagonal().head<6>().setConstant(1e-4);
  P.diagonal().tail<6>().setConstant(1e-2);
  P.topRightCorner<6, 6>().diagonal().setConstant(5e-4);
  P.bottomLeftCorner<6, 6>().diagonal().setConstant(5e-4);
  return P;
}

DeviationFilter begun() {
  DeviationFilter filter(kNoise, kAcceleration);
  filter.begin(kHalf, start_state(), start_covariance());
  return filter;
}

/// The transition over t seconds and the covariance that white acceleration adds over them.
Matrix12d transition(double t) {
  Matrix12d F = Matrix12d::Identity();
  F.topRightCorner<6, 6>().diagonal().setConstant(t);
  return F;
}

Matrix12d added(double t) {
  Matrix12d Q = Matrix12d::Zero();
  Q.topLeftCorner<6, 6>().diagonal() = t * t * t / 3.0 * kNoise;
  Q.topRightCorner<6, 6>().diagonal() = t * t / 2.0 * kNoise;
  Q.bottomLeftCorner<6, 6>().diagonal() = t * t / 2.0 * kNoise;
  Q.bottomRightCorner<6, 6>().diagonal() = t * kNoise;
  return Q;
}

Vector6d moved(double t) {
  return start_state().head<6>() + t * start_state().tail<6>() + 0.5 * t * t * kAcceleration;
}

TEST(DeviationFilter, MovesOnAsWhiteAccelerationDoes) {
  DeviationFilter filter = begun();
  filter.predict(kHalf);
  const double t = 2.0 * kHalf;
  EXPECT_TRUE(near(filter.state().head<6>(), moved(t), 1e-12));
  EXPECT_TRUE(near(filter.state().tail<6>(), start_state().tail<6>() + t * kAcceleration, 1e-12));
  EXPECT_TRUE(near(filter.covariance(),
                   transition(t) * start_covariance() * transition(t).transpose() + added(t),
                   1e-12));
}

TEST(DeviationFilter, DoesNotDependOnTheNumberOfSteps) {
  DeviationFilter once = begun(), often = begun();
  once.predict(kHalf);
  for (const double s : {-0.04, -0.01, 0.001, 0.02, kHalf}) often.predict(s);
  EXPECT_TRUE(near(often.state(), once.state(), 1e-12));
  EXPECT_TRUE(near(often.covariance(), once.covariance(), 1e-12));
  EXPECT_TRUE(near(often.deviations().poses, once.deviations().poses, 1e-12));
}

TEST(DeviationFilter, DoesNotGoBack) {
  DeviationFilter filter = begun();
  filter.predict(0.02);
  const Vector12d before = filter.state();
  filter.predict(0.01);
  EXPECT_EQ(filter.state(), before);
}

TEST(DeviationFilter, KeepsTheDeviationsAtBeginAndMiddle) {
  DeviationFilter filter = begun();
  for (const double s : {-0.01, 0.01, kHalf}) filter.predict(s);
  const SweepDeviations result = filter.deviations();
  EXPECT_TRUE(near(result.poses.head<6>(), moved(0.0), 1e-12));
  EXPECT_TRUE(near(result.poses.segment<6>(6), moved(kHalf), 1e-12));
  EXPECT_TRUE(near(result.poses.tail<6>(), moved(2.0 * kHalf), 1e-12));
  const Matrix12d middle =
      transition(kHalf) * start_covariance() * transition(kHalf).transpose() + added(kHalf);
  EXPECT_TRUE(
      near(result.covariance.block<6, 6>(0, 0), start_covariance().topLeftCorner<6, 6>(), 1e-12));
  EXPECT_TRUE(near(result.covariance.block<6, 6>(6, 6), middle.topLeftCorner<6, 6>(), 1e-12));
  // Begin and end: what the begin knew, moved on.
  EXPECT_TRUE(near(result.covariance.block<6, 6>(12, 0),
                   (transition(2.0 * kHalf) * start_covariance()).topLeftCorner<6, 6>(), 1e-12));
  EXPECT_TRUE(near(result.covariance, result.covariance.transpose().eval(), 1e-15));
}

registration::NdtPart part() {
  registration::NdtPart part;
  part.hessian.diagonal() = six(4e4, 1e4, 2e4, 1e6, 2e6, 3e6);
  part.hessian(0, 1) = part.hessian(1, 0) = 5e3;
  part.gradient = six(100.0, -50.0, 30.0, 400.0, -200.0, 100.0);
  return part;
}

/// The least-squares solution of the prior and of weight * (d^T H d / 2 + g^T d).
TEST(DeviationFilter, MeasuresAsLeastSquaresDo) {
  constexpr double kWeight = 0.3;
  DeviationFilter filter = begun();
  filter.measure(part(), kWeight);
  Matrix12d information = start_covariance().inverse();
  const Vector12d right_of_prior = information * start_state();
  information.topLeftCorner<6, 6>() += kWeight * part().hessian;
  Vector12d right = right_of_prior;
  right.head<6>() -= kWeight * part().gradient;
  EXPECT_TRUE(near(filter.state(), information.inverse() * right, 1e-9));
  EXPECT_TRUE(near(filter.covariance(), information.inverse(), 1e-9));
}

TEST(DeviationFilter, IgnoresWhatHasNoWeight) {
  DeviationFilter filter = begun();
  filter.measure(part(), 0.0);
  EXPECT_EQ(filter.state(), start_state());
  EXPECT_EQ(filter.covariance(), start_covariance());
}

/// Two measurements in turn are one of their sum.
TEST(DeviationFilter, AddsUpMeasurements) {
  DeviationFilter once = begun(), twice = begun();
  once.measure(part(), 1.0);
  twice.measure(part(), 0.25);
  twice.measure(part(), 0.75);
  EXPECT_TRUE(near(twice.state(), once.state(), 1e-9));
  EXPECT_TRUE(near(twice.covariance(), once.covariance(), 1e-9));
}

TEST(DeviationFilter, ImprovesTheBeginByWhatIsMeasuredAtTheEnd) {
  DeviationFilter filter = begun();
  filter.predict(kHalf);
  const SweepDeviations before = filter.deviations();
  filter.measure(part(), 1.0);
  const SweepDeviations after = filter.deviations();
  for (int i = 0; i < 12; ++i) {
    EXPECT_LT(after.covariance(i, i), before.covariance(i, i)) << i;
  }
  EXPECT_GT((after.poses.head<6>() - before.poses.head<6>()).norm(), 1e-4);
}

TEST(SweepDeviations, CombineWithTheirCovariance) {
  SweepDeviations deviations;
  deviations.poses << six(1, 2, 3, 4, 5, 6), six(10, 20, 30, 40, 50, 60),
      six(100, 200, 300, 400, 500, 600);
  Eigen::Matrix<double, 18, 18> root;
  for (int i = 0; i < 18; ++i) {
    for (int k = 0; k < 18; ++k) root(i, k) = std::sin(1.0 + i + 3.0 * k);
  }
  deviations.covariance = root * root.transpose();
  const Eigen::Vector3d weights(0.5, -1.0, 2.0);
  Eigen::Matrix<double, 6, 18> J = Eigen::Matrix<double, 6, 18>::Zero();
  for (int i = 0; i < 3; ++i) J.middleCols<6>(6 * i) = weights[i] * Matrix6d::Identity();
  EXPECT_TRUE(near(deviations.combined(weights), J * deviations.poses, 1e-9));
  EXPECT_TRUE(
      near(deviations.covariance_of(weights), J * deviations.covariance * J.transpose(), 1e-9));
}

}  // namespace
}  // namespace lidar_mapping::front_end
