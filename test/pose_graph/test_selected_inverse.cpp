// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/pose_graph/block_cholesky.hpp"
#include "lidar_mapping/pose_graph/selected_inverse.hpp"

namespace lidar_mapping::pose_graph {
namespace {

using Matrix = SelectedInverse::Matrix;

Matrix sparse(const Eigen::MatrixXd& dense) {
  return dense.triangularView<Eigen::Lower>().toDenseMatrix().sparseView();
}

SelectedInverse inverse_of(const Eigen::MatrixXd& dense) {
  return SelectedInverse::of(sparse(dense)).value();
}

TEST(SelectedInverse, OfOneNumberIsItsInverse) {
  EXPECT_DOUBLE_EQ(inverse_of(Eigen::MatrixXd::Constant(1, 1, 4.0)).at(0, 0), 0.25);
}

// A chain of unit springs on a wall: the inverse is min(i, j) + 1.
TEST(SelectedInverse, OfAChainIsTheCommonLength) {
  constexpr int kNodes = 6;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kNodes, kNodes);
  for (int i = 0; i < kNodes; ++i) {
    A(i, i) = i + 1 < kNodes ? 2.0 : 1.0;
    if (i > 0) A(i, i - 1) = A(i - 1, i) = -1.0;
  }
  const SelectedInverse inverse = inverse_of(A);
  for (int i = 0; i < kNodes; ++i) {
    EXPECT_NEAR(inverse.at(i, i), i + 1.0, 1e-12);
    if (i > 0) {
      EXPECT_NEAR(inverse.at(i - 1, i), i, 1e-12);
      EXPECT_EQ(inverse.at(i, i - 1), inverse.at(i - 1, i));
    }
  }
}

// The entry (2, 1) of A is chosen so that the entry of the factor is zero, but is in its pattern.
TEST(SelectedInverse, KeepsZeroEntriesOfTheFactor) {
  Eigen::MatrixXd A(4, 4);
  A << 4, 2, 2, 1,  //
      2, 5, 1, 0,   //
      2, 1, 5, 0,   //
      1, 0, 0, 3;
  const Eigen::MatrixXd dense = A.inverse();
  const SelectedInverse inverse = inverse_of(A);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(inverse.at(i, j), dense(i, j), 1e-12);
  }
}

TEST(SelectedInverse, RefusesSingularMatricesAndMissingEntries) {
  EXPECT_FALSE(SelectedInverse::of(sparse(-Eigen::MatrixXd::Identity(2, 2))));
  const SelectedInverse inverse = inverse_of(Eigen::MatrixXd::Identity(3, 3));
  EXPECT_THROW(inverse.at(0, 1), InputError) << "the factor has no such entry";
  EXPECT_THROW(inverse.at(0, 3), InputError);
  EXPECT_THROW(inverse.at(-1, 0), InputError);
}

/// A graph like that of a drive: a chain with loops, and a prior on each node.
struct RandomSystem {
  RandomSystem(unsigned seed, int nodes, int loops) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    std::uniform_int_distribution<int> pick(0, nodes - 1);
    for (int i = 1; i < nodes; ++i) pairs.emplace_back(i - 1, i);
    for (int k = 0; k < loops; ++k) {
      const int a = pick(engine);
      const int b = pick(engine);
      if (a != b) pairs.emplace_back(a, b);
    }
    system = std::make_unique<BlockCholesky<6>>(nodes, pairs);
    system->set_zero();
    dense = Eigen::MatrixXd::Zero(6 * nodes, 6 * nodes);
    const auto random = [&] {
      return Matrix6d::NullaryExpr([&](Eigen::Index, Eigen::Index) { return normal(engine); });
    };
    for (int i = 0; i < nodes; ++i) add(i, Matrix6d::Identity());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [a, b] = pairs[k];
      const Matrix6d first = random();
      const Matrix6d second = random();
      add(a, first.transpose() * first);
      add(b, second.transpose() * second);
      system->add_pair(k, first.transpose() * second);
      dense.block<6, 6>(6 * a, 6 * b) += first.transpose() * second;
      dense.block<6, 6>(6 * b, 6 * a) += second.transpose() * first;
    }
  }

  void add(int node, const Matrix6d& block) {
    system->add_diagonal(node, block);
    dense.block<6, 6>(6 * node, 6 * node) += block;
  }

  std::vector<std::pair<int, int>> pairs;
  std::unique_ptr<BlockCholesky<6>> system;
  Eigen::MatrixXd dense;
};

TEST(SelectedInverse, AgreesWithTheDenseInverseForRandomGraphs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const int nodes = 3 + 2 * static_cast<int>(seed);
    const RandomSystem random(seed, nodes, 3 * static_cast<int>(seed % 5));
    const Eigen::MatrixXd dense = random.dense.inverse();
    const SelectedInverse inverse = random.system->selected_inverse().value();
    const double limit = 1e-9 * dense.cwiseAbs().maxCoeff();
    const auto error = [&](int a, int b) {
      const Matrix6d block = random.system->block(inverse, a, b);
      return (block - dense.block<6, 6>(6 * a, 6 * b)).cwiseAbs().maxCoeff();
    };
    for (int i = 0; i < nodes; ++i) EXPECT_LT(error(i, i), limit) << "seed " << seed;
    for (const auto& [a, b] : random.pairs) {
      EXPECT_LT(error(a, b), limit) << "seed " << seed;
      EXPECT_LT(error(b, a), limit) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
