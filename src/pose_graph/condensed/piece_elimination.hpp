// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "condensed/condensed_problem.hpp"
#include "condensed/elimination_pieces.hpp"

namespace lidar_mapping::pose_graph {

/// What the factors of a piece say about its border: a dense matrix and a gradient, the exact
/// marginal over the nodes of the piece (the Schur complement).
template <int size>
struct BorderInformation {
  /// Lower triangle of blocks, column after column: those of one column from the diagonal on.
  std::vector<Eigen::Matrix<double, size, size>> blocks;
  std::vector<Eigen::Matrix<double, size, 1>> gradient;  ///< per node of the border
  /// Diagonals of the matrix before the elimination, which damping is measured by.
  std::vector<Eigen::Matrix<double, size, 1>> diagonal;
  double gain = 0.0;        ///< expected decrease of the cost by the nodes of the piece
  bool is_definite = true;  ///< false: the matrix of the piece is not positive definite
};

/// Squared lengths that damping adds to a diagonal of the normal equations, as the
/// Levenberg-Marquardt method of Ceres does.
template <int size>
Eigen::Matrix<double, size, 1> damping_of(const Eigen::Matrix<double, size, 1>& diagonal,
                                          double damping) {
  // The least scale of a direction that no factor measures. Chosen: the default of Ceres.
  constexpr double kLeastDiagonal = 1e-6;
  return damping * diagonal.cwiseMax(kLeastDiagonal);
}

/// Eliminates the nodes of one piece from the normal equations, by a Cholesky factorisation in
/// blocks. An object is used for one piece after the other and keeps its memory.
template <int size>
class PieceElimination {
 public:
  using Block = Eigen::Matrix<double, size, size>;
  using Vector = Eigen::Matrix<double, size, 1>;

  /// Linearises the factors of the piece at the current states and eliminates its nodes.
  BorderInformation<size> eliminate(const CondensedProblem<size>& problem, const Piece& piece,
                                    double damping);
  /// After eliminate(): writes the steps of the nodes of the piece into their segments of `step`.
  /// `remaining` has the steps of all remaining nodes. Returns the damping over these steps.
  double substitute(const Piece& piece, const Eigen::VectorXd& remaining,
                    Eigen::VectorXd& step) const;

 private:
  void assemble(const CondensedProblem<size>& problem, const Piece& piece,
                BorderInformation<size>& border);
  void add_to_node(const Piece& piece, int node, const Block& block, const Vector& gradient,
                   BorderInformation<size>& border);
  bool eliminate_column(const Piece& piece, int column, BorderInformation<size>& border);

  std::vector<Block> diagonal_;  ///< its lower triangle becomes the factor
  std::vector<Block> entries_;
  std::vector<Vector> gradient_;  ///< becomes the forward substitution
  std::vector<Vector> damping_;
};

extern template class PieceElimination<3>;
extern template class PieceElimination<6>;

}  // namespace lidar_mapping::pose_graph
