// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace lidar_mapping::pose_graph {

/// A factor within a piece. Nodes are numbered within the piece: its own in the order of
/// elimination, then those of its border.
struct PieceFactor {
  int factor = 0;
  int first = -1;   ///< of its nodes; -1: that node is fixed
  int second = -1;  ///< -1: that node is fixed, or there is none
  int entry = -1;   ///< of the block between both among the piece's entries; -1: none
};

/// A piece of a graph: nodes that are connected only with each other and with the nodes of the
/// border. If they are eliminated, what they say about the border is left over.
struct Piece {
  std::vector<int> nodes;            ///< unknowns, in the order of elimination
  std::vector<int> border;           ///< numbers among the remaining nodes, ascending
  std::vector<int> column_begin;     ///< per node and one more: where its entries begin in `rows`
  std::vector<int> rows;             ///< of the factor of the matrix below the diagonal, see above
  std::vector<PieceFactor> factors;  ///< those with a node of this piece
};

/// How the unknowns of a graph are eliminated: piece by piece, then the remaining nodes.
struct EliminationPieces {
  std::vector<Piece> pieces;   ///< independent of each other
  std::vector<int> remaining;  ///< unknowns that belong to no piece, in the order of elimination
  /// Factors that lie on remaining nodes alone. Nodes are numbered among these; `entry` is unused.
  std::vector<PieceFactor> remaining_factors;
};

/// Divides a graph of unknowns 0 to `unknowns` - 1. `factors` has the two unknowns of each factor;
/// -1 for a fixed node, or none. The order of elimination fills in little (AMD); a piece is a
/// subtree of its elimination tree with at most `largest_piece` nodes. The result does not depend
/// on the number of threads (0: all cores).
EliminationPieces divide_for_elimination(int unknowns,
                                         const std::vector<std::pair<int, int>>& factors,
                                         int largest_piece, int threads);

}  // namespace lidar_mapping::pose_graph
