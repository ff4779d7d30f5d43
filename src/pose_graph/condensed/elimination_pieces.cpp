// SPDX-License-Identifier: BSD-3-Clause
#include "condensed/elimination_pieces.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::pose_graph {

namespace {

using Pairs = std::vector<std::pair<int, int>>;

constexpr signed char kEntry = 1;  // chosen: any value but zero says that there is an entry

/// The number in the order of elimination of each unknown.
std::vector<int> elimination_positions(int unknowns, const Pairs& factors) {
  // The values mean nothing; small ones save a hundred megabytes for a million nodes.
  using Matrix = Eigen::SparseMatrix<signed char, Eigen::ColMajor, int>;
  std::vector<int> position(unknowns);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  {
    std::vector<Eigen::Triplet<signed char>> entries;
    entries.reserve(unknowns + factors.size());
    for (int i = 0; i < unknowns; ++i) entries.emplace_back(i, i, kEntry);
    for (const auto& [a, b] : factors) {
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), kEntry);
    }
    Matrix pattern(unknowns, unknowns);
    pattern.setFromTriplets(entries.begin(), entries.end(),
                            [](signed char /*a*/, signed char /*b*/) { return kEntry; });
    entries = {};
    Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), permutation);
  }
  for (int i = 0; i < unknowns; ++i) position[permutation.indices()[i]] = i;
  return position;
}

/// Lists of numbers, one after the other.
struct Lists {
  std::vector<int> begin;  ///< of each list, and the end of the last one
  std::vector<int> values;

  const int* first(int list) const { return values.data() + begin[list]; }
  const int* last(int list) const { return values.data() + begin[list + 1]; }
};

/// Sorts the values 0 to `keys.size()` - 1 into lists by their keys; those below zero are left out.
Lists lists_by_key(const std::vector<int>& keys, int count) {
  Lists lists;
  lists.begin.assign(count + 1, 0);
  for (const int key : keys) {
    if (key >= 0) ++lists.begin[key + 1];
  }
  std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
  lists.values.resize(lists.begin.back());
  std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] >= 0) lists.values[next[keys[i]]++] = static_cast<int>(i);
  }
  return lists;
}

/// For each position, the later (or else the earlier) positions that a factor connects it with.
Lists neighbours(const Pairs& factors, const std::vector<int>& position, bool later) {
  Lists lists;
  lists.begin.assign(position.size() + 1, 0);
  const auto ordered = [&](const std::pair<int, int>& factor) {
    const auto [low, high] = std::minmax({position[factor.first], position[factor.second]});
    return later ? std::pair(low, high) : std::pair(high, low);
  };
  const auto is_pair = [](const std::pair<int, int>& f) { return f.first >= 0 && f.second >= 0; };
  for (const auto& factor : factors) {
    if (is_pair(factor)) ++lists.begin[ordered(factor).first + 1];
  }
  std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
  lists.values.resize(lists.begin.back());
  std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
  for (const auto& factor : factors) {
    if (!is_pair(factor)) continue;
    const auto [from, to] = ordered(factor);
    lists.values[next[from]++] = to;
  }
  return lists;
}

/// The parent of each position in the elimination tree (Liu 1990); -1 at a root.
std::vector<int> elimination_tree(const Lists& earlier) {
  const int count = static_cast<int>(earlier.begin.size()) - 1;
  std::vector<int> parent(count, -1);
  std::vector<int> ancestor(count, -1);  // shortcuts towards the root
  for (int i = 0; i < count; ++i) {
    for (const int* k = earlier.first(i); k != earlier.last(i); ++k) {
      for (int node = *k; node != -1 && node < i;) {
        const int next = ancestor[node];
        ancestor[node] = i;
        if (next == -1) parent[node] = i;
        node = next;
      }
    }
  }
  return parent;
}

/// The number of the subtree with at most `largest` nodes that each position belongs to, numbered
/// in the order of their roots; -1 if it belongs to none. Returns their count, too.
std::pair<std::vector<int>, int> subtrees(const std::vector<int>& parent, int largest) {
  const int count = static_cast<int>(parent.size());
  std::vector<int> size(parent.size(), 1);
  for (int i = 0; i < count; ++i) {
    if (parent[i] >= 0) size[parent[i]] += size[i];
  }
  std::vector<int> tree(parent.size(), -1);
  int trees = 0;
  for (int i = 0; i < count; ++i) {
    const int above = parent[i];
    if (size[i] <= largest && (above < 0 || size[above] > largest)) {
      tree[i] = trees++;
    }
  }
  for (int i = count - 1; i >= 0; --i) {
    if (tree[i] < 0 && size[i] <= largest) tree[i] = tree[parent[i]];
  }
  return {std::move(tree), trees};
}

/// What all pieces are made from.
struct Division {
  const Pairs& factors;
  std::vector<int> position;    ///< of each unknown
  std::vector<int> unknown_at;  ///< each position
  std::vector<int> parent;      ///< elimination tree of positions
  std::vector<int> tree;        ///< piece of each position; -1: it remains
  std::vector<int> local;       ///< number of each position in its piece, or among the remaining
  Lists later;                  ///< neighbours of each position that are eliminated after it
};

/// Builds one piece from its positions, which ascend.
class PieceBuilder {
 public:
  PieceBuilder(const Division& division, const int* first, const int* last)
      : division_(division), positions_(first, last) {}

  Piece build(const int* first_factor, const int* last_factor) {
    for (const int position : positions_) {
      piece_.nodes.push_back(division_.unknown_at[position]);
    }
    find_children();
    for (std::size_t column = 0; column < positions_.size(); ++column) add_column(column);
    piece_.column_begin.push_back(static_cast<int>(piece_.rows.size()));
    number_rows();
    for (const int* factor = first_factor; factor != last_factor; ++factor) add_factor(*factor);
    return std::move(piece_);
  }

 private:
  void find_children() {
    child_.assign(positions_.size(), -1);
    sibling_.assign(positions_.size(), -1);
    for (std::size_t i = 0; i + 1 < positions_.size(); ++i) {
      const int above = division_.parent[positions_[i]];
      const std::size_t parent = division_.local[above];
      sibling_[i] = child_[parent];
      child_[parent] = static_cast<int>(i);
    }
  }

  /// Rows of a column: its later neighbours, and the rows of its children.
  void add_column(std::size_t column) {
    const int position = positions_[column];
    std::vector<int>& rows = piece_.rows;
    scratch_.assign(division_.later.first(position), division_.later.last(position));
    for (int child = child_[column]; child >= 0; child = sibling_[child]) {
      // The first row of a child is its parent.
      const auto begin = rows.begin() + piece_.column_begin[child];
      const auto end = static_cast<std::size_t>(child) + 1 < piece_.column_begin.size()
                           ? rows.begin() + piece_.column_begin[child + 1]
                           : rows.end();
      scratch_.insert(scratch_.end(), begin + 1, end);
    }
    std::sort(scratch_.begin(), scratch_.end());
    scratch_.erase(std::unique(scratch_.begin(), scratch_.end()), scratch_.end());
    piece_.column_begin.push_back(static_cast<int>(rows.size()));
    rows.insert(rows.end(), scratch_.begin(), scratch_.end());
  }

  /// All rows outside of the piece are those of its root, the last column.
  void number_rows() {
    border_.assign(piece_.rows.begin() + *(piece_.column_begin.end() - 2), piece_.rows.end());
    for (int& row : piece_.rows) row = local_of_position(row);
    for (const int position : border_) piece_.border.push_back(division_.local[position]);
  }

  int local_of_position(int position) const {
    if (position <= positions_.back()) return division_.local[position];
    const auto found = std::lower_bound(border_.begin(), border_.end(), position);
    return static_cast<int>(positions_.size()) + static_cast<int>(found - border_.begin());
  }

  int local_of(int unknown) const {
    return unknown < 0 ? -1 : local_of_position(division_.position[unknown]);
  }

  void add_factor(int factor) {
    const auto [a, b] = division_.factors[factor];
    PieceFactor result{factor, local_of(a), local_of(b), -1};
    if (a >= 0 && b >= 0) {
      const auto [column, row] = std::minmax({result.first, result.second});
      const int* begin = piece_.rows.data() + piece_.column_begin[column];
      const int* end = piece_.rows.data() + piece_.column_begin[column + 1];
      result.entry = static_cast<int>(std::lower_bound(begin, end, row) - piece_.rows.data());
    }
    piece_.factors.push_back(result);
  }

  const Division& division_;
  std::vector<int> positions_;
  std::vector<int> border_;  ///< positions
  std::vector<int> child_, sibling_;
  std::vector<int> scratch_;
  Piece piece_;
};

/// The position at which a factor is used up: that of its node which is eliminated first. -1 if all
/// of its nodes are fixed.
int first_position(const std::pair<int, int>& factor, const std::vector<int>& position) {
  const int a = factor.first < 0 ? -1 : position[factor.first];
  const int b = factor.second < 0 ? -1 : position[factor.second];
  return a < 0 || b < 0 ? std::max(a, b) : std::min(a, b);
}

/// Numbers the positions within their pieces, and those that remain.
void number_positions(Division& division, const Lists& positions, EliminationPieces& result) {
  division.local.resize(division.position.size());
  for (std::size_t i = 0; i < division.tree.size(); ++i) {
    if (division.tree[i] >= 0) continue;
    division.local[i] = static_cast<int>(result.remaining.size());
    result.remaining.push_back(division.unknown_at[i]);
  }
  for (int piece = 0; piece + 1 < static_cast<int>(positions.begin.size()); ++piece) {
    for (const int* i = positions.first(piece); i != positions.last(piece); ++i) {
      division.local[*i] = static_cast<int>(i - positions.first(piece));
    }
  }
}

/// Sorts the factors by their pieces, and collects those of the remaining nodes.
Lists sort_factors(const Division& division, int pieces, EliminationPieces& result) {
  const auto local_of = [&](int unknown) {
    return unknown < 0 ? -1 : division.local[division.position[unknown]];
  };
  std::vector<int> piece_of(division.factors.size(), -1);
  for (std::size_t i = 0; i < division.factors.size(); ++i) {
    const int first = first_position(division.factors[i], division.position);
    if (first < 0) continue;
    piece_of[i] = division.tree[first];
    if (piece_of[i] >= 0) continue;
    const auto [a, b] = division.factors[i];
    result.remaining_factors.push_back({static_cast<int>(i), local_of(a), local_of(b), -1});
  }
  return lists_by_key(piece_of, pieces);
}

}  // namespace

EliminationPieces divide_for_elimination(int unknowns, const Pairs& factors, int largest_piece,
                                         int threads) {
  EliminationPieces result;
  Division division{factors, elimination_positions(unknowns, factors), {}, {}, {}, {}, {}};
  division.unknown_at.resize(unknowns);
  for (int i = 0; i < unknowns; ++i) division.unknown_at[division.position[i]] = i;
  division.parent = elimination_tree(neighbours(factors, division.position, false));
  int count = 0;
  std::tie(division.tree, count) = subtrees(division.parent, largest_piece);
  division.later = neighbours(factors, division.position, true);
  const Lists positions = lists_by_key(division.tree, count);
  number_positions(division, positions, result);
  const Lists factors_of = sort_factors(division, count, result);
  result.pieces.resize(count);
  parallel_chunks(count, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int piece = static_cast<int>(i);
      PieceBuilder builder(division, positions.first(piece), positions.last(piece));
      result.pieces[i] = builder.build(factors_of.first(piece), factors_of.last(piece));
    }
  });
  return result;
}

}  // namespace lidar_mapping::pose_graph
