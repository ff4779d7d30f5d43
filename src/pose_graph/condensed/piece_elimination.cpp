// SPDX-License-Identifier: BSD-3-Clause
#include "condensed/piece_elimination.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/gauss_newton.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// Where a column of a packed lower triangle of `rows` rows begins; the diagonal comes first.
std::size_t packed_column(std::size_t rows, std::size_t column) {
  return column * rows - column * (column + 1) / 2 + column;
}

/// Cholesky factorisation in place, of the lower triangle. The diagonal becomes that of the inverse
/// factor, because it is only divided by. Returns false if it is not positive definite.
template <int size>
bool factorize(Eigen::Matrix<double, size, size>& matrix) {
  for (int j = 0; j < size; ++j) {
    double pivot = matrix(j, j);
    for (int k = 0; k < j; ++k) pivot -= matrix(j, k) * matrix(j, k);
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    matrix(j, j) = inverse;
    for (int i = j + 1; i < size; ++i) {
      double value = matrix(i, j);
      for (int k = 0; k < j; ++k) value -= matrix(i, k) * matrix(j, k);
      matrix(i, j) = value * inverse;
    }
  }
  return true;
}

/// X L^T = B for X, in place.
template <int size>
void divide(const Eigen::Matrix<double, size, size>& factor,
            Eigen::Matrix<double, size, size>& block) {
  for (int j = 0; j < size; ++j) {
    for (int k = 0; k < j; ++k) block.col(j).noalias() -= factor(j, k) * block.col(k);
    block.col(j) *= factor(j, j);
  }
}

template <int size>
void forward_substitute(const Eigen::Matrix<double, size, size>& factor,
                        Eigen::Matrix<double, size, 1>& vector) {
  for (int j = 0; j < size; ++j) {
    for (int k = 0; k < j; ++k) vector[j] -= factor(j, k) * vector[k];
    vector[j] *= factor(j, j);
  }
}

template <int size>
void backward_substitute(const Eigen::Matrix<double, size, size>& factor,
                         Eigen::Matrix<double, size, 1>& vector) {
  for (int j = size - 1; j >= 0; --j) {
    for (int k = j + 1; k < size; ++k) vector[j] -= factor(k, j) * vector[k];
    vector[j] *= factor(j, j);
  }
}

/// target -= a b^T.
template <int size>
void subtract_product(const Eigen::Matrix<double, size, size>& a,
                      const Eigen::Matrix<double, size, size>& b,
                      Eigen::Matrix<double, size, size>& target) {
  for (int j = 0; j < size; ++j) {
    Eigen::Matrix<double, size, 1> column = target.col(j);
    for (int k = 0; k < size; ++k) column -= b(j, k) * a.col(k);
    target.col(j) = column;
  }
}

}  // namespace

template <int size>
BorderInformation<size> PieceElimination<size>::eliminate(const CondensedProblem<size>& problem,
                                                          const Piece& piece, double damping) {
  const std::size_t nodes = piece.nodes.size();
  const std::size_t border_nodes = piece.border.size();
  diagonal_.assign(nodes, Block::Zero());
  entries_.assign(piece.rows.size(), Block::Zero());
  gradient_.assign(nodes, Vector::Zero());
  BorderInformation<size> border;
  border.blocks.assign(border_nodes * (border_nodes + 1) / 2, Block::Zero());
  border.gradient.assign(border_nodes, Vector::Zero());
  border.diagonal.assign(border_nodes, Vector::Zero());
  assemble(problem, piece, border);
  damping_.assign(damping > 0.0 ? nodes : 0, Vector::Zero());
  for (std::size_t i = 0; i < damping_.size(); ++i) {
    damping_[i] = damping_of<size>(diagonal_[i].diagonal(), damping);
    diagonal_[i].diagonal() += damping_[i];
  }
  for (std::size_t column = 0; column < nodes && border.is_definite; ++column) {
    border.is_definite = eliminate_column(piece, static_cast<int>(column), border);
  }
  return border;
}

template <int size>
void PieceElimination<size>::assemble(const CondensedProblem<size>& problem, const Piece& piece,
                                      BorderInformation<size>& border) {
  FactorBlocks<size> blocks;
  for (const PieceFactor& factor : piece.factors) {
    problem.linearise(factor.factor, blocks);
    if (factor.first >= 0) {
      add_to_node(piece, factor.first, blocks.first, blocks.first_gradient, border);
    }
    if (factor.second >= 0) {
      add_to_node(piece, factor.second, blocks.second, blocks.second_gradient, border);
    }
    if (factor.entry < 0) continue;
    // Entries lie below the diagonal: in the row of the node that is eliminated later.
    if (factor.first > factor.second) {
      entries_[factor.entry] += blocks.cross;
    } else {
      entries_[factor.entry] += blocks.cross.transpose();
    }
  }
}

template <int size>
void PieceElimination<size>::add_to_node(const Piece& piece, int node, const Block& block,
                                         const Vector& gradient, BorderInformation<size>& border) {
  const std::size_t nodes = piece.nodes.size();
  if (static_cast<std::size_t>(node) < nodes) {
    diagonal_[node] += block;
    diagonal_[node].diagonal() += kDiagonalScaling * block.diagonal();
    gradient_[node] += gradient;
    return;
  }
  const std::size_t row = static_cast<std::size_t>(node) - nodes;
  Block& target = border.blocks[packed_column(piece.border.size(), row)];
  target += block;
  target.diagonal() += kDiagonalScaling * block.diagonal();
  border.gradient[row] += gradient;
  border.diagonal[row] += block.diagonal();
}

template <int size>
bool PieceElimination<size>::eliminate_column(const Piece& piece, int column,
                                              BorderInformation<size>& border) {
  const int nodes = static_cast<int>(piece.nodes.size());
  Block& factor = diagonal_[column];
  if (!factorize<size>(factor)) return false;
  Vector& solved = gradient_[column];
  forward_substitute<size>(factor, solved);
  border.gain += solved.squaredNorm();
  const int begin = piece.column_begin[column];
  const int end = piece.column_begin[column + 1];
  for (int i = begin; i < end; ++i) divide<size>(factor, entries_[i]);
  for (int i = begin; i < end; ++i) {
    const int target = piece.rows[i];
    const Block& a = entries_[i];
    if (target >= nodes) {
      const std::size_t first = target - nodes;
      Block* blocks = border.blocks.data() + packed_column(piece.border.size(), first) - first;
      for (int k = i; k < end; ++k) {
        subtract_product<size>(entries_[k], a, blocks[piece.rows[k] - nodes]);
      }
      border.gradient[first].noalias() -= a * solved;
      continue;
    }
    subtract_product<size>(a, a, diagonal_[target]);
    gradient_[target].noalias() -= a * solved;
    // The target's column has all of these rows, and more between them.
    int entry = piece.column_begin[target];
    for (int k = i + 1; k < end; ++k) {
      while (piece.rows[entry] < piece.rows[k]) ++entry;
      subtract_product<size>(entries_[k], a, entries_[entry]);
    }
  }
  return true;
}

template <int size>
double PieceElimination<size>::substitute(const Piece& piece, const Eigen::VectorXd& remaining,
                                          Eigen::VectorXd& step) const {
  const int nodes = static_cast<int>(piece.nodes.size());
  const auto step_of = [&](int row) {
    const double* steps = row < nodes ? step.data() : remaining.data();
    const int number = row < nodes ? piece.nodes[row] : piece.border[row - nodes];
    return Eigen::Map<const Vector>(steps + size * static_cast<std::ptrdiff_t>(number));
  };
  double damped = 0.0;
  for (int column = nodes - 1; column >= 0; --column) {
    Vector solved = -gradient_[column];
    for (int i = piece.column_begin[column]; i < piece.column_begin[column + 1]; ++i) {
      solved.noalias() -= entries_[i].transpose() * step_of(piece.rows[i]);
    }
    backward_substitute<size>(diagonal_[column], solved);
    step.segment<size>(size * static_cast<Eigen::Index>(piece.nodes[column])) = solved;
    if (!damping_.empty()) {
      damped += damping_[column].dot(solved.cwiseAbs2());
    }
  }
  return damped;
}

template class PieceElimination<3>;
template class PieceElimination<6>;

}  // namespace lidar_mapping::pose_graph
