// SPDX-License-Identifier: BSD-3-Clause
// The motion during a scan: straight lines and circles, which can be written down.

#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/scan_motion.hpp"

#include "near.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::near;

TurningAtTime turning(const Eigen::Vector3d& omega) {
  return [omega](double /*time*/) { return omega; };
}
VelocityAtTime driving(const Eigen::Vector3d& velocity) {
  return [velocity](double /*time*/, const Eigen::Vector3d& /*omega*/) { return velocity; };
}

/// Pose after `time` on a circle, driven at 10 m/s with 0.5 rad/s to the left.
Pose on_circle(double time) {
  const double angle = 0.5 * time;
  return {exp_so3({0.0, 0.0, angle}),
          {20.0 * std::sin(angle), 20.0 * (1.0 - std::cos(angle)), 0.0}};
}
ScanMotion circle(double begin, double end) {
  return *integrated(begin, end, turning({0.0, 0.0, 0.5}), driving({10.0, 0.0, 0.0}));
}

TEST(ScanMotion, OfACircleIsOnTheCircle) {
  const ScanMotion motion = circle(-0.05, 0.1);
  for (const double time : {-0.05, -0.02, 0.0, 0.03, 0.1}) {
    EXPECT_TRUE(near(motion.at(time), on_circle(time), 1e-5)) << time;
  }
}

TEST(ScanMotion, IsTheIdentityAtTheStamp) {
  EXPECT_TRUE(near(circle(-0.05, 0.1).at(0.0), Pose::Identity(), 1e-15));
  EXPECT_TRUE(near(circle(0.0, 0.1).at(0.0), Pose::Identity(), 1e-15));
  EXPECT_TRUE(near(circle(-0.1, 0.0).at(0.0), Pose::Identity(), 1e-15));
}

TEST(ScanMotion, CoversItsSpanAndIsConstantBeyond) {
  const ScanMotion motion = circle(-0.0501, 0.0999);
  const double end =
      motion.begin + motion.step * static_cast<double>(motion.T_stamp_knot.size() - 1);
  EXPECT_LE(motion.begin, -0.0501);
  EXPECT_GE(end, 0.0999);
  EXPECT_TRUE(near(motion.at(9.0), motion.at(end), 1e-12));
  EXPECT_TRUE(near(motion.at(-9.0), motion.at(motion.begin), 1e-12));
}

TEST(ScanMotion, IsThatOfTheEndAtATimeThatIsNotANumber) {
  const ScanMotion motion = circle(-0.05, 0.1);
  EXPECT_TRUE(near(motion.at(std::nan("")), motion.T_stamp_knot.back(), 1e-15));
}

TEST(ScanMotion, HasTwoKnotsEvenOfAnInstant) {
  const ScanMotion motion = circle(0.0, 0.0);
  EXPECT_GE(motion.T_stamp_knot.size(), 2U);
  EXPECT_TRUE(near(motion.at(0.0), Pose::Identity(), 1e-15));
}

TEST(ScanMotion, FollowsAccelerations) {
  const VelocityAtTime braking = [](double time, const Eigen::Vector3d& /*omega*/) {
    return Eigen::Vector3d(10.0 - 5.0 * time, 0.0, 0.0);
  };
  const ScanMotion motion = *integrated(-0.1, 0.1, turning(Eigen::Vector3d::Zero()), braking);
  for (const double time : {-0.1, 0.04, 0.1}) {
    const Eigen::Vector3d expected(10.0 * time - 2.5 * time * time, 0.0, 0.0);
    EXPECT_TRUE(near(motion.at(time).translation, expected, 1e-9)) << time;
  }
}

TEST(ScanMotion, HasNoTranslationWithoutAVelocity) {
  const ScanMotion motion = *integrated(-0.1, 0.1, turning({0.3, 0.0, 0.0}), nullptr);
  EXPECT_TRUE(near(motion.at(0.1), {exp_so3({0.03, 0.0, 0.0}), {0.0, 0.0, 0.0}}, 1e-9));
}

TEST(ScanMotion, GivesTheVelocityTheRateOfItsInstant) {
  const TurningAtTime faster = [](double time) { return Eigen::Vector3d(0.0, 0.0, 2.0 + time); };
  const VelocityAtTime check = [](double time, const Eigen::Vector3d& omega) {
    EXPECT_NEAR(omega.z(), 2.0 + time, 1e-12);
    return Eigen::Vector3d(1.0, 0.0, 0.0);
  };
  EXPECT_TRUE(integrated(-0.01, 0.01, faster, check));
}

TEST(ScanMotion, IsUnknownIfAValueIsMissing) {
  const TurningAtTime until = [](double time) -> MaybeVector {
    if (time > 0.05) return std::nullopt;
    return Eigen::Vector3d(0.0, 0.0, 0.1);
  };
  EXPECT_TRUE(integrated(-0.1, 0.05, until, nullptr));
  EXPECT_FALSE(integrated(-0.1, 0.1, until, nullptr));
  const VelocityAtTime since = [](double time, const Eigen::Vector3d& /*omega*/) -> MaybeVector {
    if (time < -0.05) return std::nullopt;
    return Eigen::Vector3d(1.0, 0.0, 0.0);
  };
  EXPECT_FALSE(integrated(-0.1, 0.1, turning({0.0, 0.0, 0.1}), since));
}

TEST(MeanAngularVelocity, IsThatFromTheFirstToTheLastKnot) {
  EXPECT_TRUE(
      near(mean_angular_velocity(circle(-0.05, 0.1)), Eigen::Vector3d(0.0, 0.0, 0.5), 1e-9));
  const TurningAtTime uneven = [](double time) { return Eigen::Vector3d(0.0, 0.0, 4.0 * time); };
  const ScanMotion motion = *integrated(0.0, 0.1, uneven, nullptr);
  EXPECT_TRUE(near(mean_angular_velocity(motion), Eigen::Vector3d(0.0, 0.0, 0.2), 1e-6))
      << "half of the last rate";
}

TEST(WithoutUniformTurning, NothingIsLeftOfAUniformOne) {
  const Eigen::Vector3d omega(0.2, -0.1, 0.5);
  const ScanMotion motion = *integrated(-0.05, 0.1, turning(omega), driving({10.0, 0.0, 0.0}));
  const ScanMotion rest = without_uniform_turning(motion, omega);
  ASSERT_EQ(rest.T_stamp_knot.size(), motion.T_stamp_knot.size());
  for (std::size_t i = 0; i < rest.T_stamp_knot.size(); ++i) {
    EXPECT_NEAR(rotation_angle(rest.T_stamp_knot[i].rotation), 0.0, 1e-9);
    EXPECT_TRUE(near(rest.T_stamp_knot[i].translation, motion.T_stamp_knot[i].translation, 1e-15));
  }
}

TEST(WithoutUniformTurning, ThePartsGiveTheWhole) {
  const TurningAtTime uneven = [](double time) { return Eigen::Vector3d(3.0 * time, 0.1, 0.4); };
  const ScanMotion motion = *integrated(-0.05, 0.1, uneven, nullptr);
  const Eigen::Vector3d omega(0.05, 0.1, 0.3);
  const ScanMotion rest = without_uniform_turning(motion, omega);
  const UnevenTurning rotations = turning_of(rest);
  EXPECT_EQ(rotations.begin, motion.begin);
  EXPECT_EQ(rotations.step, motion.step);
  for (const double time : {-0.05, 0.0, 0.05, 0.1}) {
    const Eigen::Quaterniond whole = exp_so3(omega * time) * rotations.at(time);
    EXPECT_NEAR(rotation_angle(whole.conjugate() * motion.at(time).rotation), 0.0, 1e-6) << time;
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
