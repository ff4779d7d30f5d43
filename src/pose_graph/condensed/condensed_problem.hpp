// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::pose_graph {

/// A factor in the normal equations of its nodes: blocks of the matrix and parts of the gradient,
/// with the weight of its kernel. `size` is the dimension of a node's update.
template <int size>
struct FactorBlocks {
  Eigen::Matrix<double, size, size> first;   ///< diagonal block of the first node
  Eigen::Matrix<double, size, size> second;  ///< diagonal block of the second node, if there is one
  Eigen::Matrix<double, size, size> cross;   ///< row of the first, column of the second node
  Eigen::Matrix<double, size, 1> first_gradient;
  Eigen::Matrix<double, size, 1> second_gradient;
};

/// A graph as the condensed solver needs it, whatever holds its states and factors. All functions
/// that are const are called from several threads.
template <int size>
class CondensedProblem {
 public:
  CondensedProblem() = default;
  CondensedProblem(const CondensedProblem&) = delete;
  CondensedProblem& operator=(const CondensedProblem&) = delete;
  virtual ~CondensedProblem() = default;

  /// Nodes are numbered from 0.
  virtual int node_count() const = 0;
  /// Factors are numbered from 0.
  virtual int factor_count() const = 0;
  /// The nodes of a factor; the second is kNoNode if there is none.
  virtual std::pair<int, int> nodes_of(int factor) const = 0;
  /// True for a node that keeps its state.
  virtual bool is_fixed(int node) const = 0;

  /// Cost of a factor at the current states, under its kernel.
  virtual double cost(int factor) const = 0;
  /// Linearises a factor at the current states.
  virtual void linearise(int factor, FactorBlocks<size>& blocks) const = 0;

  /// Keeps the current states for restore(), and updates those of the `nodes` by a step that has
  /// one segment of `size` numbers for each of them.
  virtual void apply(const std::vector<int>& nodes, const Eigen::VectorXd& step) = 0;
  /// Takes the last apply() back.
  virtual void restore() = 0;
};

}  // namespace lidar_mapping::pose_graph
