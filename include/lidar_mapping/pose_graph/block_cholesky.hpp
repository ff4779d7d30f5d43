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

/// Sparse Cholesky factorisation of a symmetric positive definite matrix of `size` x `size` blocks.
/// Each node has one block row; given pairs of nodes have blocks off the diagonal. The
/// fill-reducing ordering (AMD) is computed for the nodes instead of the scalars and is kept, so
/// that several systems with the pattern of one graph share the analysis.
template <int size>
class BlockCholesky {
 public:
  /// The block of a node or of a pair of nodes.
  using Block = Eigen::Matrix<double, size, size>;

  /// A zero matrix for nodes 0 to `nodes` - 1 with blocks for these pairs of different nodes.
  BlockCholesky(int nodes, const std::vector<std::pair<int, int>>& pairs);

  /// Sets all entries to zero; the pattern stays.
  void set_zero();
  /// Adds a symmetric block on the diagonal.
  void add_diagonal(int node, const Block& block);
  /// Adds a block in the row of the pair's first node and the column of its second node. Its
  /// transpose is added implicitly. `pair` is the position in the list given to the constructor.
  void add_pair(std::size_t pair, const Block& block);
  /// Factorises the matrix. Returns false if it is not positive definite.
  bool factorize();
  /// Solves the system with the last factor for one or several columns. The rows of right-hand
  /// sides and solutions are in the order of the nodes.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides);

  /// The entries of the inverse for at least all nodes and pairs. Empty if the matrix is not
  /// positive definite.
  std::optional<SelectedInverse> selected_inverse() const { return SelectedInverse::of(lower_); }
  /// One block of that inverse. Throws InputError if it does not hold the block.
  Block block(const SelectedInverse& inverse, int row_node, int column_node) const;

 private:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  void compute_ordering(int nodes, const std::vector<std::pair<int, int>>& pairs);
  void build_pattern(int nodes, const std::vector<std::pair<int, int>>& pairs);

  std::vector<int> row_of_;  ///< position of each node in the elimination order
  /// Where a pair's block begins in each of its scalar columns, and whether it is stored
  /// transposed.
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
