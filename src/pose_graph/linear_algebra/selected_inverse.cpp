// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/selected_inverse.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <Eigen/SparseCholesky>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::pose_graph {

std::optional<SelectedInverse> SelectedInverse::of(const Matrix& lower) {
  // SimplicialLLT keeps all entries of the pattern in order of the rows, also those that happen to
  // be zero. They are needed for Z.
  const Eigen::SimplicialLLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor(lower);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return SelectedInverse(factor.matrixL().nestedExpression());
}

SelectedInverse::SelectedInverse(Matrix factor)
    : inverse_(std::move(factor)),
      position_in_column_(static_cast<std::size_t>(inverse_.cols()), -1) {
  inverse_.makeCompressed();
  for (int column = static_cast<int>(inverse_.cols()) - 1; column >= 0; --column) {
    compute_column(column);
  }
}

/// By Z L = L^-T, whose lower triangle is zero except for 1 / L_jj on the diagonal.
void SelectedInverse::compute_column(int column) {
  multiply_column(column);
  const int begin = inverse_.outerIndexPtr()[column];
  const int end = inverse_.outerIndexPtr()[column + 1];
  double* values = inverse_.valuePtr();
  const double diagonal = values[begin];
  double diagonal_sum = 1.0 / diagonal;
  for (int k = begin + 1; k < end; ++k) {
    const double entry = -product_[k - begin] / diagonal;
    diagonal_sum -= entry * values[k];
    values[k] = entry;
  }
  values[begin] = diagonal_sum / diagonal;
}

/// Multiplies the rows of Z below the diagonal with this column of L. The columns of Z that are
/// needed come after it, and have all rows of this column by the fill-in of the factor.
void SelectedInverse::multiply_column(int column) {
  const int* outer = inverse_.outerIndexPtr();
  const int* rows = inverse_.innerIndexPtr();
  const double* values = inverse_.valuePtr();
  const int begin = outer[column];
  const int end = outer[column + 1];
  product_.assign(static_cast<std::size_t>(end - begin), 0.0);
  for (int k = begin + 1; k < end; ++k) position_in_column_[rows[k]] = k - begin;
  for (int k = begin + 1; k < end; ++k) {
    for (int entry = outer[rows[k]]; entry < outer[rows[k] + 1]; ++entry) {
      const int position = position_in_column_[rows[entry]];
      if (position < 0) continue;
      product_[position] += values[entry] * values[k];
      if (position == k - begin) continue;
      product_[k - begin] += values[entry] * values[begin + position];
    }
  }
  for (int k = begin + 1; k < end; ++k) position_in_column_[rows[k]] = -1;
}

double SelectedInverse::at(int row, int column) const {
  const auto [from, to] = std::minmax(row, column);
  if (from < 0 || to >= inverse_.cols()) {
    throw InputError("the inverse has " + std::to_string(inverse_.cols()) + " rows, and no entry " +
                     std::to_string(row) + ", " + std::to_string(column));
  }
  const int* begin = inverse_.innerIndexPtr() + inverse_.outerIndexPtr()[from];
  const int* end = inverse_.innerIndexPtr() + inverse_.outerIndexPtr()[from + 1];
  const int* found = std::lower_bound(begin, end, to);
  if (found == end || *found != to) {
    throw InputError("entry " + std::to_string(row) + ", " + std::to_string(column) +
                     " of the inverse was not selected: the factor has none there");
  }
  return inverse_.valuePtr()[found - inverse_.innerIndexPtr()];
}

}  // namespace lidar_mapping::pose_graph
