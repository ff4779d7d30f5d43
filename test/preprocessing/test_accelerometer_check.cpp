// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "checks/accelerometer_check.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr double kPeriod = 0.01;  // s
constexpr double kGravity = 9.81;

using Fault = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// A sensor that is carried: it nods by `nod` (rad) and each step shakes it by 6 m/s^2.
AccelerometerCheck carried(double nod, double seconds, const Fault& fault) {
  AccelerometerCheck check;
  for (int i = 0; i < static_cast<int>(seconds / kPeriod); ++i) {
    const double t = kPeriod * i;
    ImuSample sample;
    sample.stamp = from_seconds(t);
    const double angle = nod * std::sin(2.0 * t);
    sample.angular_velocity = {0.0, 2.0 * nod * std::cos(2.0 * t), 0.3};
    const Eigen::Vector3d force(0.5 * std::sin(25.0 * t), 0.4 * std::cos(13.0 * t),
                                kGravity + 6.0 * std::sin(25.0 * t));
    sample.linear_acceleration = fault(exp_so3({0.0, angle, 0.0}).conjugate() * force);
    check.add(sample);
  }
  return check;
}

const Fault kNone = [](const Eigen::Vector3d& a) { return a; };

TEST(AccelerometerCheck, AcceptsCorrectAccelerations) {
  EXPECT_EQ(carried(0.4, 30.0, kNone).problem(), AccelerationProblem::kNone);
  EXPECT_EQ(carried(0.0, 30.0, kNone).problem(), AccelerationProblem::kNone);
}

TEST(AccelerometerCheck, FindsAndReportsTheUnit) {
  const auto check = carried(0.2, 8.0, [](const auto& a) { return a / kGravity; });
  EXPECT_EQ(check.problem(), AccelerationProblem::kNotGravity);
  EXPECT_NE(check.sentence().find("imu_acceleration_unit to G"), std::string::npos);
}

TEST(AccelerometerCheck, FindsThatGravityOrAnAxisIsMissing) {
  for (const Fault& fault :
       {Fault([](const auto&) { return Eigen::Vector3d(0.0, 0.0, 0.0); }),
        Fault([](const auto& a) { return Eigen::Vector3d(a.x(), a.y(), 0.0); }),
        Fault([](const auto& a) { return Eigen::Vector3d(3.28 * a); })}) {
    const auto check = carried(0.2, 8.0, fault);
    EXPECT_EQ(check.problem(), AccelerationProblem::kNotGravity);
    EXPECT_EQ(check.sentence().find("imu_acceleration_unit"), std::string::npos);
  }
}

TEST(AccelerometerCheck, FindsValuesThatNeverChange) {
  const Fault made_up = [](const auto&) { return Eigen::Vector3d(0.0, 0.0, kGravity); };
  EXPECT_EQ(carried(0.2, 8.0, made_up).problem(), AccelerationProblem::kConstant);
  EXPECT_EQ(carried(0.0, 8.0, made_up).problem(), AccelerationProblem::kNone)
      << "on a plane without noise that is what is felt";
  const Fault dead = [](const auto& a) { return Eigen::Vector3d(0.0, a.y(), a.z()); };
  EXPECT_EQ(carried(0.3, 8.0, dead).problem(), AccelerationProblem::kConstant);
}

TEST(AccelerometerCheck, RejectsOnlyAfterAWhileAndRecovers) {
  const Fault in_g = [](const auto& a) { return a / kGravity; };
  EXPECT_EQ(carried(0.2, 4.0, in_g).problem(), AccelerationProblem::kNone);
  int samples = 0;
  const Fault at_first = [&](const auto& a) {
    return Eigen::Vector3d(++samples < 1000 ? a / kGravity : a);
  };
  EXPECT_EQ(carried(0.2, 20.0, at_first).problem(), AccelerationProblem::kNone);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
