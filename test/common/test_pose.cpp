// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/rotations.hpp"

#include "near.hpp"

namespace lidar_mapping {
namespace {

class RandomPoses : public testing::Test {
 protected:
  Vector6d random_vector(double scale) {
    Vector6d v;
    for (int i = 0; i < 6; ++i) v[i] = scale * uniform_(engine_);
    return v;
  }
  Pose random_pose() { return perturbed(Pose::Identity(), random_vector(3.0)); }

  std::mt19937 engine_{7};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST_F(RandomPoses, InverseUndoes) {
  for (int i = 0; i < 100; ++i) {
    const Pose T = random_pose();
    EXPECT_TRUE(test::near(T * T.inverse(), Pose::Identity(), 1e-12));
  }
}

TEST_F(RandomPoses, DifferenceInvertsPerturbed) {
  for (int i = 0; i < 100; ++i) {
    const Pose T = random_pose();
    const Vector6d d = random_vector(1.0);
    EXPECT_TRUE(test::near(difference(T, perturbed(T, d)), d, 1e-12));
  }
}

TEST_F(RandomPoses, MatrixComesBack) {
  for (int i = 0; i < 100; ++i) {
    const Pose T = random_pose();
    EXPECT_TRUE(test::near(Pose::from_matrix(T.matrix()), T, 1e-12));
  }
}

TEST_F(RandomPoses, LongChainsStayRotations) {
  Pose T;
  const Pose step = perturbed(Pose::Identity(), random_vector(0.01));
  for (int i = 0; i < 100000; ++i) T = T * step;
  EXPECT_NEAR(T.rotation_matrix().determinant(), 1.0, 1e-9);
}

TEST_F(RandomPoses, AngleIgnoresTheSignOfTheQuaternion) {
  for (double angle = 0.0; angle < M_PI; angle += 0.1) {
    Eigen::Quaterniond q = exp_so3(angle * Eigen::Vector3d::UnitZ());
    EXPECT_NEAR(rotation_angle(q), angle, 1e-12);
    q.coeffs() *= -1.0;
    EXPECT_NEAR(rotation_angle(q), angle, 1e-12);
  }
}

TEST_F(RandomPoses, AdjointMovesAPerturbationToTheOtherSide) {
  for (int i = 0; i < 100; ++i) {
    const Pose T = random_pose();
    const Vector6d d = random_vector(1e-6);
    const Pose left = perturbed(Pose::Identity(), adjoint(T) * d) * T;
    EXPECT_TRUE(test::near(left, perturbed(T, d), 1e-10));
  }
}

TEST_F(RandomPoses, ComposedCovarianceMatchesScatter) {
  const Pose T_a_b = random_pose();
  const Pose T_b_c = random_pose();
  const Covariance6 first = diagonal_covariance(0.01, 0.002);
  const Covariance6 second = diagonal_covariance(0.02, 0.001);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma_m, double sigma_rad) {
    Vector6d d;
    for (int i = 0; i < 6; ++i) d[i] = normal(engine_) * (i < 3 ? sigma_m : sigma_rad);
    return d;
  };
  Covariance6 scatter = Covariance6::Zero();
  const int runs = 20000;
  for (int i = 0; i < runs; ++i) {
    const Pose noisy = perturbed(T_a_b, draw(0.01, 0.002)) * perturbed(T_b_c, draw(0.02, 0.001));
    const Vector6d d = difference(T_a_b * T_b_c, noisy);
    scatter += d * d.transpose() / runs;
  }
  const Covariance6 predicted = compose_covariance(first, T_b_c, second);
  EXPECT_LT((scatter - predicted).norm() / predicted.norm(), 0.05);
}

TEST(Covariance, ParentAxesAndBack) {
  const Pose T{exp_so3({0.1, 0.2, 1.5}), {1.0, 2.0, 3.0}};
  Covariance6 covariance = diagonal_covariance(0.1, 0.01);
  covariance(0, 0) = 4.0;
  EXPECT_TRUE(
      test::near(in_parent_axes(in_parent_axes(covariance, T), T.inverse()), covariance, 1e-12));
}

TEST(Covariance, RefusesWhatIsNone) {
  Covariance6 covariance = diagonal_covariance(0.1, 0.01);
  EXPECT_TRUE(is_valid_covariance(covariance));
  covariance(0, 0) = -1.0;
  EXPECT_FALSE(is_valid_covariance(covariance));
  covariance(0, 0) = std::nan("");
  EXPECT_FALSE(is_valid_covariance(covariance));
}

TEST(Rotations, AreAboutTheFixedAxesInTheOrderRollPitchYaw) {
  const Eigen::Vector3d p(1.0, 2.0, 3.0);
  const Eigen::Vector3d expected =
      exp_so3({0.0, 0.0, 0.9}) * (exp_so3({0.0, 0.4, 0.0}) * (exp_so3({-0.3, 0.0, 0.0}) * p));
  EXPECT_TRUE(test::near(rotation_from_rpy(-0.3, 0.4, 0.9) * p, expected, 1e-12));
  EXPECT_LT(rotation_angle(rotation_about_z(0.9).conjugate() * exp_so3({0.0, 0.0, 0.9})), 1e-12);
}

TEST(Rotations, AndAPositionAreWrittenInMetresAndDegrees) {
  const Pose pose = pose_from_degrees({1.0, 2.0, 3.0, 0.0, 0.0, 90.0});
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_NEAR(yaw_of(pose.rotation), M_PI / 2.0, 1e-12);
  EXPECT_EQ(rotation_angle(pose_from_degrees({1.0, 2.0, 3.0}).rotation), 0.0);
}

}  // namespace
}  // namespace lidar_mapping
