// SPDX-License-Identifier: BSD-3-Clause
// The states of nodes and their updates, and the algebra that residuals share.

#include <array>
#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pose_graph/tangent.hpp"

#include "near.hpp"
#include "residuals/residual_algebra.hpp"

namespace lidar_mapping::pose_graph {
namespace {

using test::near;

const Pose kPose = {exp_so3({0.2, -0.3, 1.1}), {4.0, -5.0, 6.0}};

Eigen::Quaterniond turned(double yaw) { return exp_so3({0.0, 0.0, yaw}); }

TEST(StateBlock, HoldsAPose) {
  const StateBlock block = to_block(kPose);
  EXPECT_EQ(block[1], -5.0);
  EXPECT_EQ(block[6], kPose.rotation.w()) << "w comes last";
  EXPECT_TRUE(near(to_pose(block.data()), kPose, 1e-12));
}

TEST(StateBlock, GivesAUnitQuaternion) {
  StateBlock block = to_block(kPose);
  for (std::size_t i = 3; i < 7; ++i) block[i] *= 1.5;
  EXPECT_TRUE(near(to_pose(block.data()), kPose, 1e-12));
}

TEST(PlanarBlock, HoldsPositionAndHeading) {
  const StateBlock block = to_planar_block({turned(0.7), {2.0, 3.0, 0.0}});
  EXPECT_EQ(block[0], 2.0);
  EXPECT_EQ(block[1], 3.0);
  EXPECT_NEAR(block[2], 0.7, 1e-12);
  EXPECT_TRUE(near(to_planar_pose(block.data()), Pose{turned(0.7), {2.0, 3.0, 0.0}}, 1e-12));
}

TEST(PlanarBlock, LeavesOutHeightAndTilt) {
  const Pose tilted = {turned(0.7) * exp_so3({0.0, 0.2, 0.0}), {2.0, 3.0, 9.0}};
  const StateBlock block = to_planar_block(tilted);
  EXPECT_NEAR(block[2], 0.7, 1e-12);
  EXPECT_TRUE(near(to_planar_pose(block.data()), Pose{turned(0.7), {2.0, 3.0, 0.0}}, 1e-12));
}

TEST(PlanarBlock, MayHaveTurnedSeveralTimes) {
  const std::array<double, 3> block = {0.0, 0.0, 0.7 + 6.0 * kPi};
  EXPECT_TRUE(near(to_planar_pose(block.data()), Pose{turned(0.7), {0.0, 0.0, 0.0}}, 1e-9));
}

TEST(Retract, MovesInTheAxesOfTheNode) {
  const StateBlock block = to_block({turned(0.5 * kPi), {1.0, 1.0, 1.0}});
  const std::array<double, 6> d = {2.0, 0.0, 0.5, 0.0, 0.0, 0.0};
  const StateBlock moved = retract(block.data(), d.data());
  EXPECT_TRUE(near(to_pose(moved.data()), Pose{turned(0.5 * kPi), {1.0, 3.0, 1.5}}, 1e-12));
}

// As in g2o, the update is the vector part of a unit quaternion.
TEST(Retract, TurnsByTwiceTheArcSine) {
  const std::array<double, 6> d = {0.0, 0.0, 0.0, 0.0, 0.0, std::sin(0.2)};
  const StateBlock block = to_block({turned(0.3), {1.0, 2.0, 3.0}});
  EXPECT_TRUE(near(to_pose(retract(block.data(), d.data()).data()),
                   Pose{turned(0.7), {1.0, 2.0, 3.0}}, 1e-12));
}

TEST(Retract, TurnsByHalfATurnAtMost) {
  const std::array<double, 6> d = {0.0, 0.0, 0.0, 0.0, 3.0, 0.0};
  const Pose turned_over = to_pose(retract(to_block(Pose()).data(), d.data()).data());
  EXPECT_TRUE(turned_over.rotation.coeffs().allFinite());
  EXPECT_TRUE(
      near(turned_over * Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d(-1.0, 2.0, -3.0), 1e-12));
}

TEST(TangentUpdate, IsRetractWithTheIdentityAboveZerosAsItsDerivative) {
  TangentUpdate update;
  const StateBlock block = to_block(kPose);
  const std::array<double, 6> d = {0.1, -0.2, 0.3, 0.05, -0.1, 0.15};
  StateBlock plus{};
  ASSERT_TRUE(update.Plus(block.data(), d.data(), plus.data()));
  EXPECT_EQ(plus, retract(block.data(), d.data()));
  std::array<double, 42> jacobian{};
  jacobian.fill(7.0);
#if LIDAR_MAPPING_CERES_HAS_MANIFOLD
  ASSERT_TRUE(update.PlusJacobian(block.data(), jacobian.data()));
#else
  ASSERT_TRUE(update.ComputeJacobian(block.data(), jacobian.data()));
#endif
  const Eigen::Map<const Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian.data());
  Eigen::Matrix<double, 7, 6> expected = Eigen::Matrix<double, 7, 6>::Zero();
  expected.topRows<6>().setIdentity();
  EXPECT_TRUE(near(J, expected, 1e-15));
}

const Eigen::Matrix3d& some_covariance() {
  static const Eigen::Matrix3d covariance =
      (Eigen::Matrix3d() << 4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 0.01 + 0.25).finished();
  return covariance;
}

TEST(SquareRoot, IsUpperTriangularAndGivesTheInformation) {
  const Eigen::Matrix3d S = square_root<3>(some_covariance());
  EXPECT_TRUE(near(S.transpose() * S, some_covariance(), 1e-12));
  EXPECT_EQ(S(1, 0), 0.0);
  EXPECT_EQ(S(2, 0), 0.0);
  EXPECT_EQ(S(2, 1), 0.0);
}

TEST(Whitening, MakesAUnitCovariance) {
  const Eigen::Matrix3d W = whitening<3>(some_covariance());
  EXPECT_TRUE(near(W * some_covariance() * W.transpose(), Eigen::Matrix3d::Identity(), 1e-9));
}

TEST(OrthogonalBasis, IsOrthonormal) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(0.0, 0.0, 1.0), Eigen::Vector3d(-1.0, 0.0, 0.0),
        Eigen::Vector3d(1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0)}) {
    const Eigen::Matrix<double, 2, 3> rows = orthogonal_basis(direction);
    EXPECT_TRUE(near(rows * rows.transpose(), Eigen::Matrix2d::Identity(), 1e-12));
    EXPECT_TRUE(near(rows * direction, Eigen::Vector2d(0.0, 0.0), 1e-12));
  }
}

TEST(WriteJacobian, FillsSixColumnsAndClearsTheSeventh) {
  std::array<double, 14> target{};
  target.fill(7.0);
  TangentMatrix<2> derivative;
  derivative << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0;
  write_jacobian<2>(target.data(), derivative);
  const std::array<double, 14> expected = {1.0,  2.0,  3.0,  4.0,  5.0,  6.0,  0.0,
                                           -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, 0.0};
  EXPECT_EQ(target, expected);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
