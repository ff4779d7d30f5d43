// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/antenna_fit.hpp"

#include "gnss/fix_scatter.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using lidar_mapping::test::near;
using test::at;

/// A slalom at a speed that changes, in East-North-Up and (turned) by dead reckoning; the fixes are
/// `delay` seconds late and the antenna is `arm_error` beside its place in tf.
AntennaFit slalom(double delay, const Eigen::Vector2d& arm_error) {
  AntennaFit fit;
  const Eigen::Vector2d arm(-0.4, 0.5);
  const Eigen::Matrix2d R_enu_dr = Eigen::Rotation2Dd(1.1).toRotationMatrix();
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.02);
  const auto speed = [](double t) { return 8.0 + 3.0 * std::sin(0.5 * t); };
  const auto yaw = [](double t) { return 0.9 * std::sin(0.35 * t); };
  const double step = 0.001;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (int i = 0; i < 60000; ++i) {
    const double t = i * step;
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(yaw(t)).toRotationMatrix();
    const Eigen::Vector2d v_base(speed(t), 0.0);
    if (i % 100 == 0) {
      const double rate = 0.9 * 0.35 * std::cos(0.35 * t);
      const auto velocity = [&](const Eigen::Vector2d& l) -> Eigen::Vector2d {
        return R * (v_base + rate * Eigen::Vector2d(-l.y(), l.x()));
      };
      const Eigen::Vector2d true_arm = arm + arm_error;
      TrackedFix fix;
      fix.stamp = at(t);
      const Eigen::Vector2d antenna = p + R * true_arm - delay * velocity(true_arm);
      fix.p_enu = R_enu_dr * antenna + Eigen::Vector2d(noise(engine), noise(engine));
      fix.yaw_dr = yaw(t);
      fix.p_dr_base = p;
      fix.v_dr = velocity(arm);
      fix.p_base_antenna = arm;
      fit.add(fix);
    }
    p += step * (R * v_base);
  }
  return fit;
}

TEST(AntennaFit, FindsTheDelayOfTheStamps) {
  for (const double delay : {-0.1, 0.0, 0.05}) {
    const auto result = slalom(delay, Eigen::Vector2d::Zero()).result(0.03);
    EXPECT_NEAR(result.delay, delay, 0.005);
    EXPECT_LT(result.delay_sigma, 0.01);
  }
}

TEST(AntennaFit, FindsThePositionOfTheAntenna) {
  const Eigen::Vector2d arm_error(1.2, -0.9);
  const auto result = slalom(0.0, arm_error).result(3.0);
  EXPECT_TRUE(near(result.arm_error, arm_error, 0.2));
  EXPECT_LT(result.arm_sigma, 0.2);
}

TEST(AntennaFit, IsUnknownForAStandingVehicle) {
  AntennaFit fit;
  for (int i = 0; i < 600; ++i) {
    TrackedFix fix;
    fix.stamp = at(0.1 * i);
    fit.add(fix);
  }
  EXPECT_NEAR(fit.result(0.03).delay, 0.0, 1e-9);
  EXPECT_GT(fit.result(0.03).delay_sigma, 0.1);
}

FixScatter scatter_of(double true_sigma, double stated_sigma) {
  FixScatter scatter;
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, true_sigma);
  for (int i = 0; i < 300; ++i) {
    LocalFix fix;
    fix.stamp = at(0.1 * i);
    fix.p_enu = {0.8 * i + noise(engine), noise(engine), 0.0};
    fix.covariance = stated_sigma * stated_sigma * Eigen::Matrix3d::Identity();
    scatter.add(fix);
  }
  return scatter;
}

TEST(FixScatter, RaisesOnlyCovariancesThatAreTooSmall) {
  EXPECT_NEAR(std::sqrt(scatter_of(1.0, 0.1).variance_factor()), 10.0, 2.0);
  EXPECT_EQ(scatter_of(1.0, 1.0).variance_factor(), 1.0);
  EXPECT_EQ(scatter_of(0.1, 1.0).variance_factor(), 1.0);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
