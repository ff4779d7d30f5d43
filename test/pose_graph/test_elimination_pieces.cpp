// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "condensed/elimination_pieces.hpp"

namespace lidar_mapping::pose_graph {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// A chain with loops, priors, and factors to fixed nodes.
Pairs chain_with_loops(int unknowns) {
  std::mt19937 engine(1);
  Pairs factors = {{-1, -1}, {0, -1}, {-1, 5}};
  for (int i = 1; i < unknowns; ++i) factors.emplace_back(i - 1, i);
  for (int i = 50; i < unknowns; i += 4) {
    const int from = static_cast<int>(engine() % static_cast<unsigned>(i - 10));
    factors.emplace_back(i % 8 == 0 ? i : from, i % 8 == 0 ? from : i);
  }
  return factors;
}

/// The unknown that a number within a piece stands for.
int unknown_of(const EliminationPieces& division, const Piece& piece, int local) {
  if (local < 0) return -1;
  const auto number = static_cast<std::size_t>(local);
  if (number < piece.nodes.size()) return piece.nodes[number];
  const int remaining = piece.border.at(number - piece.nodes.size());
  return division.remaining.at(static_cast<std::size_t>(remaining));
}

constexpr int kUnknowns = 600;
constexpr int kLargest = 60;

TEST(EliminationPieces, HaveEachUnknownOnceAndAreNotTooLarge) {
  const EliminationPieces division =
      divide_for_elimination(kUnknowns, chain_with_loops(kUnknowns), kLargest, 1);
  std::vector<int> unknowns = division.remaining;
  EXPECT_FALSE(unknowns.empty());
  for (const Piece& piece : division.pieces) {
    EXPECT_GE(piece.nodes.size(), 1U);
    EXPECT_LE(piece.nodes.size(), static_cast<std::size_t>(kLargest));
    unknowns.insert(unknowns.end(), piece.nodes.begin(), piece.nodes.end());
  }
  std::sort(unknowns.begin(), unknowns.end());
  std::vector<int> all(kUnknowns);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(unknowns, all);
}

TEST(EliminationPieces, HaveEachFactorOnceWithItsNodes) {
  const Pairs factors = chain_with_loops(kUnknowns);
  const EliminationPieces division = divide_for_elimination(kUnknowns, factors, kLargest, 2);
  std::multiset<int> seen;
  for (const Piece& piece : division.pieces) {
    for (const PieceFactor& factor : piece.factors) {
      seen.insert(factor.factor);
      const auto& [a, b] = factors[factor.factor];
      EXPECT_EQ(unknown_of(division, piece, factor.first), a);
      EXPECT_EQ(unknown_of(division, piece, factor.second), b);
      if (a < 0 || b < 0) {
        EXPECT_EQ(factor.entry, -1);
        continue;
      }
      const auto [column, row] = std::minmax({factor.first, factor.second});
      EXPECT_GE(factor.entry, piece.column_begin.at(static_cast<std::size_t>(column)));
      EXPECT_LT(factor.entry, piece.column_begin.at(static_cast<std::size_t>(column) + 1));
      EXPECT_EQ(piece.rows.at(static_cast<std::size_t>(factor.entry)), row);
    }
  }
  for (const PieceFactor& factor : division.remaining_factors) seen.insert(factor.factor);
  EXPECT_EQ(seen.size(), factors.size() - 1) << "all but the one between fixed nodes";
  EXPECT_EQ(seen.count(0), 0U);
  for (const int factor : seen) EXPECT_EQ(seen.count(factor), 1U);
}

/// The rows of a column are those of the factor: what its elimination connects stays among the rows
/// of the columns after it.
TEST(EliminationPieces, HaveRoomForWhatEliminationConnects) {
  const EliminationPieces division =
      divide_for_elimination(kUnknowns, chain_with_loops(kUnknowns), kLargest, 1);
  for (const Piece& piece : division.pieces) {
    for (std::size_t column = 0; column < piece.nodes.size(); ++column) {
      const auto begin = piece.rows.begin() + piece.column_begin[column];
      const auto end = piece.rows.begin() + piece.column_begin[column + 1];
      EXPECT_TRUE(std::is_sorted(begin, end));
      if (begin == end || static_cast<std::size_t>(*begin) >= piece.nodes.size()) continue;
      const auto parent = static_cast<std::size_t>(*begin);
      EXPECT_GT(parent, column);
      EXPECT_TRUE(std::includes(piece.rows.begin() + piece.column_begin[parent],
                                piece.rows.begin() + piece.column_begin[parent + 1], begin + 1,
                                end));
    }
  }
}

TEST(EliminationPieces, OfASmallGraphAreOneForEachConnectedPart) {
  const EliminationPieces division =
      divide_for_elimination(6, {{0, 1}, {1, 2}, {3, 4}, {4, 5}, {3, 5}}, kLargest, 1);
  EXPECT_TRUE(division.remaining.empty());
  ASSERT_EQ(division.pieces.size(), 2U);
  EXPECT_EQ(division.pieces[0].nodes.size(), 3U);
  EXPECT_EQ(division.pieces[1].nodes.size(), 3U);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
