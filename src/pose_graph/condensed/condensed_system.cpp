// SPDX-License-Identifier: BSD-3-Clause
#include "condensed/condensed_system.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Nodes of a piece at most. Measured: on a million key frames in the streets of a town, pieces of
// 4000 take half as long again, because their blocks do not stay in the processor's cache. With
// 1000, one key frame in forty is left for the condensed graph.
constexpr int kLargestPiece = 1000;
// Pieces whose results are kept until they are added up in order. Chosen: enough for any number of
// threads, few enough that their memory does not count.
constexpr std::size_t kBatch = 1024;
// Pieces that one thread takes at a time. Chosen: they share their memory, and threads end
// together.
constexpr std::size_t kPiecesAtATime = 8;
// Factors whose costs are added up by one thread. Chosen: so that sums do not depend on threads.
constexpr std::size_t kCostChunk = 4096;

}  // namespace

struct CondensedEquations {
  Eigen::VectorXd gradient;
  Eigen::VectorXd diagonal;  ///< of the matrix before the elimination
  Eigen::VectorXd step;
  double gain = 0.0;
  double damped = 0.0;  ///< damping over the step
};

template <int size>
CondensedStructure condensed_structure(const CondensedProblem<size>& problem, int threads) {
  CondensedStructure result;
  std::vector<int> unknown_of(problem.node_count(), -1);
  std::vector<std::pair<int, int>> factors;
  factors.reserve(problem.factor_count());
  for (int factor = 0; factor < problem.factor_count(); ++factor) {
    const auto [a, b] = problem.nodes_of(factor);
    for (const int node : {a, b}) {
      if (node >= 0 && !problem.is_fixed(node)) unknown_of[node] = 0;
    }
    factors.emplace_back(a, b);
  }
  for (int node = 0; node < problem.node_count(); ++node) {
    if (unknown_of[node] < 0) continue;
    unknown_of[node] = static_cast<int>(result.nodes.size());
    result.nodes.push_back(node);
  }
  for (auto& [a, b] : factors) {
    a = unknown_of[a];
    b = b < 0 ? -1 : unknown_of[b];
  }
  result.division = divide_for_elimination(static_cast<int>(result.nodes.size()), factors,
                                           kLargestPiece, threads);
  return result;
}

template <int size>
CondensedSystem<size>::CondensedSystem(const CondensedProblem<size>& problem,
                                       CondensedStructure structure, int threads)
    : problem_(problem),
      threads_(threads),
      nodes_(std::move(structure.nodes)),
      division_(std::move(structure.division)) {
  plan_condensed_graph();
}

/// The pairs of nodes are listed in the order in which condense() adds their blocks.
template <int size>
void CondensedSystem<size>::plan_condensed_graph() {
  if (division_.remaining.empty()) return;
  std::vector<std::pair<int, int>> pairs;
  for (const Piece& piece : division_.pieces) {
    for (std::size_t column = 0; column < piece.border.size(); ++column) {
      for (std::size_t row = column + 1; row < piece.border.size(); ++row) {
        pairs.emplace_back(piece.border[row], piece.border[column]);
      }
    }
  }
  for (const PieceFactor& factor : division_.remaining_factors) {
    if (factor.first >= 0 && factor.second >= 0) pairs.emplace_back(factor.first, factor.second);
  }
  cholesky_ =
      std::make_unique<BlockCholesky<size>>(static_cast<int>(division_.remaining.size()), pairs);
}

template <int size>
CondensedStep CondensedSystem<size>::solve(double damping) {
  CondensedStep result;
  CondensedEquations condensed;
  const auto rows = size * static_cast<Eigen::Index>(division_.remaining.size());
  condensed.gradient = Eigen::VectorXd::Zero(rows);
  condensed.diagonal = Eigen::VectorXd::Zero(rows);
  if (!condense(damping, condensed) || !solve_condensed(damping, condensed)) return result;
  solve_back(damping, condensed, result);
  result.is_usable = result.step.allFinite();
  return result;
}

template <int size>
template <typename Body>
void CondensedSystem<size>::for_each_piece(std::size_t first, std::size_t count, const Body& body) {
  parallel_chunks(count, kPiecesAtATime, threads_, [&](std::size_t begin, std::size_t end) {
    std::unique_ptr<PieceElimination<size>> elimination;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!eliminations_.empty()) {
        elimination = std::move(eliminations_.back());
        eliminations_.pop_back();
      }
    }
    if (!elimination) elimination = std::make_unique<PieceElimination<size>>();
    for (std::size_t i = begin; i < end; ++i) body(*elimination, first + i);
    const std::lock_guard<std::mutex> lock(mutex_);
    eliminations_.push_back(std::move(elimination));
  });
}

/// Eliminates all pieces. What they leave is added up in their order.
template <int size>
bool CondensedSystem<size>::condense(double damping, CondensedEquations& condensed) {
  if (cholesky_) cholesky_->set_zero();
  std::size_t pair = 0;
  std::vector<BorderInformation<size>> borders(kBatch);
  for (std::size_t batch = 0; batch < division_.pieces.size(); batch += kBatch) {
    const std::size_t count = std::min(kBatch, division_.pieces.size() - batch);
    for_each_piece(batch, count, [&](PieceElimination<size>& elimination, std::size_t piece) {
      borders[piece - batch] = elimination.eliminate(problem_, division_.pieces[piece], damping);
    });
    for (std::size_t i = 0; i < count; ++i) {
      const BorderInformation<size>& border = borders[i];
      if (!border.is_definite) return false;
      condensed.gain += border.gain;
      const std::vector<int>& nodes = division_.pieces[batch + i].border;
      std::size_t block = 0;
      for (std::size_t column = 0; column < nodes.size(); ++column) {
        const Eigen::Index at = size * static_cast<Eigen::Index>(nodes[column]);
        condensed.gradient.segment<size>(at) += border.gradient[column];
        condensed.diagonal.segment<size>(at) += border.diagonal[column];
        cholesky_->add_diagonal(nodes[column], border.blocks[block++]);
        for (std::size_t row = column + 1; row < nodes.size(); ++row) {
          cholesky_->add_pair(pair++, border.blocks[block++]);
        }
      }
    }
  }
  return true;
}

template <int size>
void CondensedSystem<size>::add_remaining_factors(CondensedEquations& condensed) {
  std::size_t pair = 0;
  for (const Piece& piece : division_.pieces) {
    pair += piece.border.size() * (piece.border.size() - (piece.border.empty() ? 0 : 1)) / 2;
  }
  FactorBlocks<size> blocks;
  for (const PieceFactor& factor : division_.remaining_factors) {
    problem_.linearise(factor.factor, blocks);
    const auto add = [&](int node, Block block, const Eigen::Matrix<double, size, 1>& gradient) {
      if (node < 0) return;
      const Eigen::Index at = size * static_cast<Eigen::Index>(node);
      condensed.gradient.segment<size>(at) += gradient;
      condensed.diagonal.segment<size>(at) += block.diagonal();
      cholesky_->add_diagonal(node, block);
    };
    add(factor.first, blocks.first, blocks.first_gradient);
    add(factor.second, blocks.second, blocks.second_gradient);
    if (factor.first >= 0 && factor.second >= 0) cholesky_->add_pair(pair++, blocks.cross);
  }
}

template <int size>
bool CondensedSystem<size>::solve_condensed(double damping, CondensedEquations& condensed) {
  if (!cholesky_) return true;
  add_remaining_factors(condensed);
  Eigen::VectorXd added = Eigen::VectorXd::Zero(condensed.diagonal.size());
  for (int node = 0; node < static_cast<int>(division_.remaining.size()); ++node) {
    const Eigen::Index at = size * static_cast<Eigen::Index>(node);
    const Eigen::Matrix<double, size, 1> diagonal = condensed.diagonal.segment<size>(at);
    if (damping > 0.0) added.segment<size>(at) = damping_of<size>(diagonal, damping);
    cholesky_->add_diagonal(node, Block(added.segment<size>(at).asDiagonal()));
  }
  if (!cholesky_->factorize()) return false;
  condensed.step = -cholesky_->solve(condensed.gradient);
  condensed.gain -= condensed.gradient.dot(condensed.step);
  condensed.damped = added.dot(condensed.step.cwiseAbs2());
  return condensed.step.allFinite();
}

template <int size>
void CondensedSystem<size>::solve_back(double damping, const CondensedEquations& condensed,
                                       CondensedStep& result) {
  result.step.resize(size * static_cast<Eigen::Index>(nodes_.size()));
  for (std::size_t i = 0; i < division_.remaining.size(); ++i) {
    result.step.segment<size>(size * static_cast<Eigen::Index>(division_.remaining[i])) =
        condensed.step.segment<size>(size * static_cast<Eigen::Index>(i));
  }
  std::vector<double> damped(division_.pieces.size());
  for_each_piece(
      0, division_.pieces.size(), [&](PieceElimination<size>& elimination, std::size_t i) {
        elimination.eliminate(problem_, division_.pieces[i], damping);
        damped[i] = elimination.substitute(division_.pieces[i], condensed.step, result.step);
      });
  result.expected_gain = condensed.damped;
  for (const double value : damped) result.expected_gain += value;
  result.expected_gain += condensed.gain;
}

template <int size>
double total_cost(const CondensedProblem<size>& problem, int threads) {
  const std::size_t count = problem.factor_count();
  std::vector<double> sums((count + kCostChunk - 1) / kCostChunk);
  parallel_chunks(count, kCostChunk, threads, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += problem.cost(static_cast<int>(i));
    sums[begin / kCostChunk] = sum;
  });
  double sum = 0.0;
  for (const double part : sums) sum += part;
  return sum;
}

template double total_cost<3>(const CondensedProblem<3>&, int);
template double total_cost<6>(const CondensedProblem<6>&, int);
template CondensedStructure condensed_structure<3>(const CondensedProblem<3>&, int);
template CondensedStructure condensed_structure<6>(const CondensedProblem<6>&, int);
template class CondensedSystem<3>;
template class CondensedSystem<6>;

}  // namespace lidar_mapping::pose_graph
