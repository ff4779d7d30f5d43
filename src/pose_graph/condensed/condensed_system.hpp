// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"

#include "condensed/condensed_problem.hpp"
#include "condensed/elimination_pieces.hpp"
#include "condensed/piece_elimination.hpp"

namespace lidar_mapping::pose_graph {

/// Which nodes of a problem move, and how they are eliminated. It does not depend on the states.
struct CondensedStructure {
  std::vector<int> nodes;  ///< those that are not fixed and have a factor: the unknowns
  EliminationPieces division;
};

/// Divides the graph of a problem. `threads` 0: all cores.
template <int size>
CondensedStructure condensed_structure(const CondensedProblem<size>& problem, int threads);

/// A step of all unknowns, and what is expected of it.
struct CondensedStep {
  bool is_usable = false;      ///< false: the equations have no finite solution
  Eigen::VectorXd step;        ///< a segment per unknown
  double expected_gain = 0.0;  ///< decrease of the linearised cost
};

/// The equations of the condensed graph, but for their matrix.
struct CondensedEquations;

/// The normal equations of a graph, solved exactly without keeping their factor: the nodes of each
/// piece are eliminated, the condensed graph of the remaining nodes is solved, and the pieces are
/// eliminated once more to solve them back. See doc/back_end.md.
template <int size>
class CondensedSystem {
 public:
  /// `threads` 0: all cores. The results have the same bits for any number of threads.
  CondensedSystem(const CondensedProblem<size>& problem, CondensedStructure structure, int threads);

  /// The nodes that have steps, in the order of their segments.
  const std::vector<int>& nodes() const { return nodes_; }

  /// Solves the equations at the current states with a fraction `damping` of their diagonal added.
  CondensedStep solve(double damping);

 private:
  using Block = Eigen::Matrix<double, size, size>;

  void plan_condensed_graph();
  bool condense(double damping, CondensedEquations& condensed);
  void add_remaining_factors(CondensedEquations& condensed);
  bool solve_condensed(double damping, CondensedEquations& condensed);
  void solve_back(double damping, const CondensedEquations& condensed, CondensedStep& result);

  /// Calls body(elimination, piece number) for a range of pieces, on several threads.
  template <typename Body>
  void for_each_piece(std::size_t first, std::size_t count, const Body& body);

  const CondensedProblem<size>& problem_;
  int threads_;
  std::vector<int> nodes_;
  EliminationPieces division_;
  std::unique_ptr<BlockCholesky<size>> cholesky_;  ///< of the condensed graph; null if it is empty
  std::mutex mutex_;
  /// Those that no thread uses at present; they keep their memory from step to step.
  std::vector<std::unique_ptr<PieceElimination<size>>> eliminations_;
};

/// Cost of all factors at the current states.
template <int size>
double total_cost(const CondensedProblem<size>& problem, int threads);

extern template CondensedStructure condensed_structure<3>(const CondensedProblem<3>&, int);
extern template CondensedStructure condensed_structure<6>(const CondensedProblem<6>&, int);
extern template class CondensedSystem<3>;
extern template class CondensedSystem<6>;

}  // namespace lidar_mapping::pose_graph
