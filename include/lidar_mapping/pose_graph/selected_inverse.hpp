// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/SparseCore>

namespace lidar_mapping::pose_graph {

/// The inverse Z of a sparse symmetric positive definite matrix A = L L^T where L has entries,
/// which is where A has them and more: by the equations of Takahashi et al. (1973), in which Z L =
/// L^-T gives column after column of Z from those behind it. It takes about as long as the factor,
/// while the whole inverse would be dense. See doc/back_end.md.
class SelectedInverse {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  /// `lower` is A in the order in which it is to be eliminated; what it has above the diagonal is
  /// not looked at. None if A is not positive definite.
  static std::optional<SelectedInverse> of(const Matrix& lower);

  /// An entry, from either side of the diagonal. Throws InputError where the factor has none.
  double at(int row, int column) const;

 private:
  explicit SelectedInverse(Matrix factor);
  void compute_column(int column);
  void multiply_column(int column);

  Matrix inverse_;  ///< lower triangle, at first the factor
  std::vector<int>
      position_in_column_;       ///< of each row in the column that is being filled; -1: none
  std::vector<double> product_;  ///< of that column: the product with what stands behind it
};

}  // namespace lidar_mapping::pose_graph
