// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "lidar_mapping/pose_graph/residuals.hpp"
#include "lidar_mapping/pose_graph/tangent.hpp"

#include "near.hpp"

namespace lidar_mapping::pose_graph {
namespace {

/// Random values with a fixed seed.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double number(double size) {
    return std::uniform_real_distribution<double>(-size, size)(engine_);
  }
  Eigen::Vector3d vector(double size) { return {number(size), number(size), number(size)}; }
  Pose pose(double size, double angle) { return {exp_so3(vector(angle)), vector(size)}; }
  template <int size>
  Eigen::Matrix<double, size, size> covariance(double scale) {
    Eigen::Matrix<double, size, size> root;
    for (int i = 0; i < root.size(); ++i) root.data()[i] = number(scale);
    return root * root.transpose() +
           0.1 * scale * scale * Eigen::Matrix<double, size, size>::Identity();
  }
  Floor floor() {
    Floor floor;
    floor.normal = (Eigen::Vector3d::UnitZ() + vector(0.2)).normalized();
    floor.offset = 1.7 + number(0.1);
    return floor;
  }

 private:
  std::mt19937 engine_;
};

using Blocks = std::vector<StateBlock>;

Eigen::VectorXd evaluate(const ceres::CostFunction& cost, const Blocks& blocks) {
  std::vector<const double*> pointers;
  for (const StateBlock& block : blocks) pointers.push_back(block.data());
  Eigen::VectorXd residual(cost.num_residuals());
  cost.Evaluate(pointers.data(), residual.data(), nullptr);
  return residual;
}

/// Derivatives of the residual by the tangent of one block (or by its planar state), one per
/// column.
Eigen::MatrixXd analytic(const ceres::CostFunction& cost, const Blocks& blocks, std::size_t which) {
  std::vector<const double*> pointers;
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    pointers.push_back(blocks[i].data());
    storage.emplace_back(
        static_cast<std::size_t>(cost.num_residuals() * cost.parameter_block_sizes()[i]));
  }
  for (auto& values : storage) jacobians.push_back(values.data());
  Eigen::VectorXd residual(cost.num_residuals());
  cost.Evaluate(pointers.data(), residual.data(), jacobians.data());
  const int columns = cost.parameter_block_sizes()[which];
  const Eigen::MatrixXd jacobian =
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[which], cost.num_residuals(), columns);
  if (columns == kPlanarBlockSize) return jacobian;
  EXPECT_EQ(jacobian.col(6).norm(), 0.0) << "the seventh column must not enter";
  return jacobian.leftCols(6);
}

StateBlock stepped(const StateBlock& block, bool planar, int axis, double step) {
  if (planar) {
    StateBlock result = block;
    result[axis] += step;
    return result;
  }
  std::array<double, 6> d{};
  d[axis] = step;
  return retract(block.data(), d.data());
}

Eigen::MatrixXd numerical(const ceres::CostFunction& cost, const Blocks& blocks,
                          std::size_t which) {
  constexpr double kStep = 1e-6;
  const bool planar = cost.parameter_block_sizes()[which] == kPlanarBlockSize;
  const int columns = planar ? 3 : 6;
  Eigen::MatrixXd jacobian(cost.num_residuals(), columns);
  for (int axis = 0; axis < columns; ++axis) {
    Blocks ahead = blocks;
    Blocks behind = blocks;
    ahead[which] = stepped(blocks[which], planar, axis, kStep);
    behind[which] = stepped(blocks[which], planar, axis, -kStep);
    jacobian.col(axis) = (evaluate(cost, ahead) - evaluate(cost, behind)) / (2.0 * kStep);
  }
  return jacobian;
}

void expect_exact_derivatives(const ceres::CostFunction& cost, const Blocks& blocks) {
  for (std::size_t which = 0; which < blocks.size(); ++which) {
    const Eigen::MatrixXd a = analytic(cost, blocks, which);
    const Eigen::MatrixXd n = numerical(cost, blocks, which);
    // Central differences with a step of 1e-6 have relative errors of about 1e-9.
    EXPECT_LT((a - n).cwiseAbs().maxCoeff(), 1e-6 * (1.0 + a.cwiseAbs().maxCoeff()))
        << "block " << which << "\nanalytic\n"
        << a << "\nnumerical\n"
        << n;
  }
}

TEST(Residuals, RelativePoseHasExactDerivatives) {
  Draw draw(1);
  for (int i = 0; i < 50; ++i) {
    const Pose first = draw.pose(10.0, 2.0);
    const Pose measured = draw.pose(5.0, 1.5);
    const auto cost = relative_pose_residual(measured, g2o_information(draw.covariance<6>(0.3)));
    expect_exact_derivatives(*cost,
                             {to_block(first), to_block(first * measured * draw.pose(1.0, 0.8))});
  }
}

TEST(Residuals, RelativePoseIsContinuousForEitherSignOfTheQuaternion) {
  Draw draw(2);
  const Pose first = draw.pose(10.0, 2.0);
  const Pose second = draw.pose(10.0, 2.0);
  StateBlock negated = to_block(second);
  for (std::size_t i = 3; i < 7; ++i) negated[i] = -negated[i];
  const auto cost = relative_pose_residual(draw.pose(5.0, 1.0), Matrix6d::Identity());
  const Eigen::VectorXd a = evaluate(*cost, {to_block(first), to_block(second)});
  EXPECT_TRUE(test::near(a, evaluate(*cost, {to_block(first), negated}), 1e-12));
}

TEST(Residuals, RelativePoseIsTheErrorOfG2o) {
  const Pose measured = {exp_so3({0.1, -0.2, 0.3}), {1.0, 2.0, 3.0}};
  const Pose actual = {exp_so3({0.15, -0.1, 0.35}), {1.1, 2.2, 2.9}};
  const auto cost = relative_pose_residual(measured, Matrix6d::Identity());
  const Pose error = measured.inverse() * actual;
  Vector6d expected;
  expected << error.translation, error.rotation.vec();
  EXPECT_TRUE(test::near(evaluate(*cost, {to_block(Pose()), to_block(actual)}), expected, 1e-12));
}

TEST(Residuals, PriorHasExactDerivatives) {
  Draw draw(3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = draw.pose(10.0, 2.0);
    const auto cost = prior_residual(pose, g2o_information(draw.covariance<6>(0.3)));
    expect_exact_derivatives(*cost, {to_block(pose * draw.pose(1.0, 1.0))});
  }
}

TEST(Residuals, AntennaHasExactDerivatives) {
  Draw draw(4);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = draw.pose(10.0, 2.0);
    const Eigen::Vector3d lever = draw.vector(2.0);
    expect_exact_derivatives(
        *antenna_horizontal_residual(draw.vector(10.0), lever, draw.covariance<2>(0.5)),
        {to_block(pose)});
    expect_exact_derivatives(*antenna_altitude_residual(3.0, lever, 0.2), {to_block(pose)});
  }
}

TEST(Residuals, TiltAndHeadingHaveExactDerivatives) {
  Draw draw(5);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = draw.pose(10.0, 0.8);
    const Eigen::Vector3d up = (Eigen::Vector3d::UnitZ() + draw.vector(0.3)).normalized();
    expect_exact_derivatives(*tilt_residual(up, 0.02), {to_block(pose)});
    expect_exact_derivatives(*heading_residual(draw.number(1.0), 0.02), {to_block(pose)});
  }
}

TEST(Residuals, FloorsHaveExactDerivatives) {
  Draw draw(6);
  for (int i = 0; i < 20; ++i) {
    const Pose first = draw.pose(10.0, 0.5);
    const Pose second = first * draw.pose(3.0, 0.3);
    const Eigen::Matrix3d covariance = draw.covariance<3>(0.1);
    expect_exact_derivatives(*common_floor_residual(draw.floor(), draw.floor(), covariance),
                             {to_block(first), to_block(second)});
  }
}

TEST(Residuals, PlanarRelativePoseHasExactDerivatives) {
  Draw draw(7);
  for (int i = 0; i < 20; ++i) {
    const auto cost = planar_relative_pose_residual(draw.vector(1.0), draw.covariance<3>(1.0));
    expect_exact_derivatives(*cost, {{draw.number(5.0), draw.number(5.0), draw.number(3.0)},
                                     {draw.number(5.0), draw.number(5.0), draw.number(3.0)}});
  }
}

// The standard deviation is squared, and half angles are taken into account.
TEST(Residuals, AnErrorOfOneStandardDeviationGivesOne) {
  const auto cost = relative_pose_residual(Pose(), g2o_information(diagonal_covariance(0.2, 0.01)));
  Vector6d d = Vector6d::Zero();
  d[0] = 0.2;
  EXPECT_NEAR(evaluate(*cost, {to_block(Pose()), to_block(perturbed(Pose(), d))}).norm(), 1.0,
              1e-9);
  d.setZero();
  d[5] = 0.01;
  EXPECT_NEAR(evaluate(*cost, {to_block(Pose()), to_block(perturbed(Pose(), d))}).norm(), 1.0,
              1e-5);
}

TEST(Tangent, MinusInvertsRetract) {
  Draw draw(8);
  const StateBlock block = to_block(draw.pose(10.0, 2.0));
  const std::array<double, 6> d = {0.1, -0.2, 0.3, 0.2, -0.1, 0.3};
  const StateBlock updated = retract(block.data(), d.data());
#if LIDAR_MAPPING_CERES_HAS_MANIFOLD
  std::array<double, 6> back{};
  TangentUpdate().Minus(updated.data(), block.data(), back.data());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back[i], d[i], 1e-12);
#endif
  EXPECT_NEAR(to_pose(updated.data()).rotation.norm(), 1.0, 1e-12);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
