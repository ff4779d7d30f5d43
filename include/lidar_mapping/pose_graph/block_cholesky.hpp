// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/CholmodSupport>
#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "lidar_mapping/pose_graph/selected_inverse.hpp"

namespace lidar_mapping::pose_graph {

/// A symmetric positive definite system of `size` x `size` blocks, one block row per node, with
/// blocks off the diagonal for given pairs of nodes. The fill-reducing order is sought on nodes
/// rather than on scalars and kept, so that several systems of one graph share the analysis.
template <int size>
class BlockCholesky {
 public:
  using Block = Eigen::Matrix<double, size, size>;

  BlockCholesky(int nodes, const std::vector<std::pair<int, int>>& pairs);

  void set_zero();
  void add_diagonal(int node, const Block& block);
  /// The block in the row of the pair's first node and the column of its second; its transpose is
  /// implied.
  void add_pair(std::size_t pair, const Block& block);
  /// False if the matrix is not positive definite.
  bool factorize();
  /// Columns of right-hand sides in the order of the nodes, and likewise their solutions.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides);

  /// The inverse at least for all nodes and pairs, and a block of it. None if the matrix is not
  /// positive definite.
  std::optional<SelectedInverse> selected_inverse() const { return SelectedInverse::of(lower_); }
  Block block(const SelectedInverse& inverse, int row_node, int column_node) const;

 private:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  void compute_ordering(int nodes, const std::vector<std::pair<int, int>>& pairs);
  void build_pattern(int nodes, const std::vector<std::pair<int, int>>& pairs);

  std::vector<int> row_of_;  ///< place of each node in the elimination order
  /// Where a pair's block begins in each of its scalar columns, and whether it is stored turned.
  struct Slot {
    int column = 0;
    int offset = 0;
    bool transposed = false;
  };
  std::vector<Slot> slots_;
  Matrix lower_;
  bool analysed_ = false;
  Eigen::CholmodDecomposition<Matrix, Eigen::Lower> cholmod_;
};

extern template class BlockCholesky<2>;
extern template class BlockCholesky<3>;
extern template class BlockCholesky<6>;

}  // namespace lidar_mapping::pose_graph
