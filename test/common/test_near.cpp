// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "near.hpp"

namespace lidar_mapping::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool contains(const testing::AssertionResult& result, const std::string& part) {
  return std::string(result.message()).find(part) != std::string::npos;
}

Pose pose_at(double x, double yaw) {
  return {exp_so3(Eigen::Vector3d(0.0, 0.0, yaw)), Eigen::Vector3d(x, 0.0, 0.0)};
}

TEST(Near, BoundsTheNormOfTheDifference) {
  const Eigen::Vector3d a(1.0, 2.0, 3.0);
  const Eigen::Vector3d b(1.0, 5.0, 7.0);
  EXPECT_TRUE(near(a, b, 5.001));
  EXPECT_FALSE(near(a, b, 4.999));
  EXPECT_FALSE(near(b, a, 4.999));
  EXPECT_FALSE(near(a, b, 5.0)) << "the bound itself is not near";
  EXPECT_FALSE(near(a, a, 0.0));
}

TEST(Near, TakesMatricesAndExpressions) {
  const Eigen::Matrix2f ones = Eigen::Matrix2f::Ones();
  EXPECT_TRUE(near(2.0F * ones, ones + ones, 1e-6));
  EXPECT_TRUE(near(ones, Eigen::Matrix2f::Zero(), 2.001));
  EXPECT_FALSE(near(ones, Eigen::Matrix2f::Zero(), 1.999)) << "Frobenius's norm is 2";
}

TEST(Near, FailsForNotANumber) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Vector3d broken(0.0, kNan, 0.0);
  for (const double tolerance : {1e-9, 1e9, kInfinity}) {
    EXPECT_FALSE(near(broken, zero, tolerance));
    EXPECT_FALSE(near(zero, broken, tolerance));
    EXPECT_FALSE(near(broken, broken, tolerance));
  }
  EXPECT_FALSE(near(zero, zero, kNan)) << "a tolerance that is none";
  const Eigen::Vector3d infinite(kInfinity, 0.0, 0.0);
  EXPECT_FALSE(near(infinite, infinite, 1e9)) << "their difference is not a number";
}

TEST(Near, FailsForPosesWithNotANumber) {
  Pose turned_nowhere;
  turned_nowhere.rotation.w() = kNan;
  for (const Pose& broken : {pose_at(kNan, 0.0), turned_nowhere}) {
    EXPECT_FALSE(near(broken, Pose(), kInfinity));
    EXPECT_FALSE(near(Pose(), broken, kInfinity));
    EXPECT_FALSE(near(broken, Pose(), kInfinity, kInfinity));
    EXPECT_FALSE(near(Pose(), broken, kInfinity, kInfinity));
  }
}

TEST(Near, BoundsMetresAndRadiansOfPosesTogether) {
  EXPECT_TRUE(near(pose_at(3.0, 0.4), pose_at(0.0, 0.0), std::hypot(3.0, 0.4) + 1e-9));
  EXPECT_FALSE(near(pose_at(3.0, 0.4), pose_at(0.0, 0.0), std::hypot(3.0, 0.4) - 1e-9));
  EXPECT_FALSE(near(pose_at(0.0, 0.4), pose_at(0.0, 0.0), 0.399)) << "a rotation alone";
}

TEST(Near, BoundsMetresAndRadiansOfPosesApart) {
  EXPECT_TRUE(near(pose_at(3.0, 0.4), pose_at(0.0, 0.0), 3.001, 0.401));
  EXPECT_FALSE(near(pose_at(3.0, 0.4), pose_at(0.0, 0.0), 2.999, 0.401));
  EXPECT_FALSE(near(pose_at(3.0, 0.4), pose_at(0.0, 0.0), 3.001, 0.399));
}

TEST(Near, FailsForVectorsOfDifferentSizes) {
  const Eigen::VectorXd two = Eigen::VectorXd::Zero(2);
  const Eigen::VectorXd three = Eigen::VectorXd::Zero(3);
  EXPECT_TRUE(near(two, two, 1e-9));
  EXPECT_FALSE(near(two, three, 1e9));
  EXPECT_TRUE(contains(near(two, three, 1e9), "sizes differ"));
}

TEST(Near, ShowsBothValuesTheDistanceAndTheTolerance) {
  const auto vectors = near(Eigen::Vector3d(1.25, 2.0, 3.0), Eigen::Vector3d(1.0, 2.0, 3.0), 0.125);
  EXPECT_TRUE(contains(vectors, "the distance 0.25 is not less than 0.125")) << vectors.message();
  EXPECT_TRUE(contains(vectors, "actual: [1.25, 2, 3]")) << vectors.message();
  EXPECT_TRUE(contains(vectors, "expected: [1, 2, 3]")) << vectors.message();

  const auto poses = near(pose_at(0.5, 0.0), pose_at(2.0, 0.0), 1.0);
  EXPECT_TRUE(contains(poses, "1.5 (m and rad) is not less than 1")) << poses.message();
  EXPECT_TRUE(contains(poses, "actual: [0.5, 0, 0] m, [0, 0, 0] rad")) << poses.message();
  EXPECT_TRUE(contains(poses, "expected: [2, 0, 0] m")) << poses.message();

  const auto apart = near(pose_at(0.5, 0.0), pose_at(2.0, 0.0), 1.0, 0.25);
  EXPECT_TRUE(contains(apart, "1.5 m and 0 rad is not less than 1 m and 0.25 rad"))
      << apart.message();
}

}  // namespace
}  // namespace lidar_mapping::test
