// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/SparseCore>

namespace lidar_mapping::pose_graph {

/// Selected entries of the inverse Z of a sparse symmetric positive definite matrix A = L L^T:
/// those where the factor L has entries, which includes all entries of A. The equations of
/// Takahashi et al. (1973), Z L = L^-T, give the columns of Z from the last to the first. This
/// takes about as long as the factorisation, while the whole inverse would be dense. See
/// doc/back_end.md.
class SelectedInverse {
 public:
  /// A sparse matrix in compressed columns.
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  /// Computes the entries for the matrix A, given in elimination order. Entries of `lower` above
  /// the diagonal are ignored. Empty if A is not positive definite.
  static std::optional<SelectedInverse> of(const Matrix& lower);

  /// One entry of Z, above or below the diagonal. Throws InputError if the factor has no entry
  /// there.
  double at(int row, int column) const;

 private:
  explicit SelectedInverse(Matrix factor);
  void compute_column(int column);
  void multiply_column(int column);

  Matrix inverse_;                       ///< lower triangle; the factor at the beginning
  std::vector<int> position_in_column_;  ///< of each row in the current column; -1: none
  std::vector<double> product_;  ///< of the current column of L with the columns of Z after it
};

}  // namespace lidar_mapping::pose_graph
