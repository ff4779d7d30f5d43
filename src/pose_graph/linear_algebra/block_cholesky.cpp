// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/block_cholesky.hpp"

#include <algorithm>

#include <Eigen/OrderingMethods>

#include "linear_algebra/single_threaded_openmp.hpp"

namespace lidar_mapping::pose_graph {

template <int size>
BlockCholesky<size>::BlockCholesky(int nodes, const std::vector<std::pair<int, int>>& pairs) {
  compute_ordering(nodes, pairs);
  build_pattern(nodes, pairs);
  cholmod_.setMode(Eigen::CholmodAuto);
  cholmod_.cholmod().print = 0;
  cholmod_.cholmod().nmethods = 1;
  cholmod_.cholmod().method[0].ordering = CHOLMOD_NATURAL;
  // AMD has postordered already, so that no step has to permute the matrix.
  cholmod_.cholmod().postorder = 0;
}

template <int size>
void BlockCholesky<size>::compute_ordering(int nodes,
                                           const std::vector<std::pair<int, int>>& pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < nodes; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [a, b] : pairs) entries.emplace_back(std::max(a, b), std::min(a, b), 1.0);
  Matrix pattern(nodes, nodes);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), permutation);
  row_of_.resize(static_cast<std::size_t>(nodes));
  for (int position = 0; position < nodes; ++position) {
    row_of_[permutation.indices()[position]] = position;
  }
}

template <int size>
void BlockCholesky<size>::build_pattern(int nodes, const std::vector<std::pair<int, int>>& pairs) {
  const auto row_of = [this](int node) { return row_of_[node]; };
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(nodes));
  for (int i = 0; i < nodes; ++i) rows[i].push_back(i);
  for (const auto& [a, b] : pairs) {
    const auto [column, row] = std::minmax({row_of(a), row_of(b)});
    rows[column].push_back(row);
  }
  std::size_t blocks = 0;
  for (auto& list : rows) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    blocks += list.size();
  }
  lower_.resize(nodes * size, nodes * size);
  lower_.resizeNonZeros(static_cast<Eigen::Index>(blocks) * size * size);
  int* inner = lower_.innerIndexPtr();
  int* outer = lower_.outerIndexPtr();
  for (const auto& list : rows) {
    for (int k = 0; k < size; ++k) {
      *outer++ = static_cast<int>(inner - lower_.innerIndexPtr());
      for (const int row : list) {
        // The diagonal block is stored completely; CHOLMOD ignores entries above the diagonal.
        for (int r = 0; r < size; ++r) *inner++ = row * size + r;
      }
    }
  }
  *outer = static_cast<int>(inner - lower_.innerIndexPtr());
  for (const auto& [a, b] : pairs) {
    const auto [column, row] = std::minmax({row_of(a), row_of(b)});
    const auto& list = rows[column];
    const auto found = std::lower_bound(list.begin(), list.end(), row);
    slots_.push_back(
        {column, static_cast<int>(found - list.begin()) * size, row_of(a) < row_of(b)});
  }
}

template <int size>
void BlockCholesky<size>::set_zero() {
  lower_.coeffs().setZero();
}

template <int size>
void BlockCholesky<size>::add_diagonal(int node, const Block& block) {
  const int column = row_of_[node] * size;
  for (int k = 0; k < size; ++k) {
    double* values = lower_.valuePtr() + lower_.outerIndexPtr()[column + k];
    Eigen::Map<Eigen::Matrix<double, size, 1>> target(values);
    target += block.col(k);
  }
}

template <int size>
void BlockCholesky<size>::add_pair(std::size_t pair, const Block& block) {
  const Slot& slot = slots_[pair];
  for (int k = 0; k < size; ++k) {
    double* values =
        lower_.valuePtr() + lower_.outerIndexPtr()[slot.column * size + k] + slot.offset;
    Eigen::Map<Eigen::Matrix<double, size, 1>> target(values);
    if (slot.transposed) {
      target += block.row(k).transpose();
    } else {
      target += block.col(k);
    }
  }
}

template <int size>
bool BlockCholesky<size>::factorize() {
  const SingleThreadedOpenMp single_threaded;
  if (!analysed_) cholmod_.analyzePattern(lower_);
  analysed_ = true;
  cholmod_.factorize(lower_);
  return cholmod_.info() == Eigen::Success;
}

template <int size>
Eigen::MatrixXd BlockCholesky<size>::solve(const Eigen::MatrixXd& right_hand_sides) {
  Eigen::MatrixXd ordered(right_hand_sides.rows(), right_hand_sides.cols());
  for (std::size_t i = 0; i < row_of_.size(); ++i) {
    ordered.middleRows<size>(row_of_[i] * size) =
        right_hand_sides.middleRows<size>(static_cast<Eigen::Index>(i) * size);
  }
  const Eigen::MatrixXd solved = cholmod_.solve(ordered);
  for (std::size_t i = 0; i < row_of_.size(); ++i) {
    ordered.middleRows<size>(static_cast<Eigen::Index>(i) * size) =
        solved.middleRows<size>(row_of_[i] * size);
  }
  return ordered;
}

template <int size>
typename BlockCholesky<size>::Block BlockCholesky<size>::block(const SelectedInverse& inverse,
                                                               int row_node,
                                                               int column_node) const {
  const int row = row_of_[row_node] * size;
  const int column = row_of_[column_node] * size;
  Block result;
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) result(r, c) = inverse.at(row + r, column + c);
  }
  return result;
}

template class BlockCholesky<2>;
template class BlockCholesky<3>;
template class BlockCholesky<6>;

}  // namespace lidar_mapping::pose_graph
