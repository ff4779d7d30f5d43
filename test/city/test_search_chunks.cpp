// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include "search_chunks.hpp"

namespace lidar_mapping::city::test {
namespace {

/// A piece of 100 m eastward from x (m), 100 key frames from `first`; without a box if `gnss` is
/// false.
Piece piece_at(KeyFrameIndex first, double x, double y, bool gnss) {
  Piece piece;
  piece.first = first;
  piece.last = first + 99;
  if (gnss) {
    piece.box.emplace();
    piece.box->extend(Eigen::Vector3d(x, y, 0.0));
    piece.box->extend(Eigen::Vector3d(x + 100.0, y, 0.0));
  }
  return piece;
}

DrivePieces straight_drive(const std::string& name, double x, double y, std::size_t pieces,
                           bool gnss = true) {
  DrivePieces drive;
  drive.drive = name;
  for (std::size_t i = 0; i < pieces; ++i) {
    const auto first = static_cast<KeyFrameIndex>(100 * i);
    drive.pieces.push_back(piece_at(first, x + 100.0 * static_cast<double>(i), y, gnss));
  }
  return drive;
}

/// The appearance of a place; equal for equal numbers.
AppearanceKey view(unsigned place) {
  std::mt19937 generator(place);
  AppearanceKey key{};
  for (std::uint8_t& step : key) step = static_cast<std::uint8_t>(generator() % 64);
  return key;
}

/// Gives each piece ten places, numbered from `first` on.
void show_places(DrivePieces& drive, unsigned first) {
  for (Piece& piece : drive.pieces) {
    for (int i = 0; i < 10; ++i) piece.places.push_back(view(first++));
  }
}

TEST(SearchChunks, BoxesThatLieNearEachOtherArePaired) {
  const auto chunks =
      find_chunks({straight_drive("a", 0.0, 0.0, 5), straight_drive("b", 250.0, 30.0, 1),
                   straight_drive("c", 0.0, 500.0, 5)});
  ASSERT_EQ(chunks.size(), 1U);
  EXPECT_EQ(chunks[0].id, "a--b--000");
  ASSERT_EQ(chunks[0].a_ranges.size(), 1U);
  EXPECT_EQ(chunks[0].a_ranges[0].first, 200U);
  EXPECT_EQ(chunks[0].a_ranges[0].last, 399U);
  EXPECT_EQ(chunks[0].b_ranges[0].last, 99U);
  EXPECT_TRUE(chunks[0].by_position);
  EXPECT_FALSE(chunks[0].by_appearance);
}

TEST(SearchChunks, LongDrivesAreSearchedInSeveralChunks) {
  const auto chunks =
      find_chunks({straight_drive("a", 0.0, 0.0, 25), straight_drive("b", 0.0, 10.0, 25)});
  ASSERT_EQ(chunks.size(), 3U);
  KeyFrameIndex next = 0;
  for (const Chunk& chunk : chunks) {
    ASSERT_EQ(chunk.b_ranges.size(), 1U);
    EXPECT_EQ(chunk.b_ranges[0].first, next) << "each key frame is searched for in one chunk";
    next = chunk.b_ranges[0].last + 1;
  }
  EXPECT_EQ(next, 2500U);
}

TEST(SearchChunks, DrivesWithoutGnssArePairedByAppearance) {
  DrivePieces a = straight_drive("a", 0.0, 0.0, 8), b = straight_drive("b", 0.0, 0.0, 2, false);
  DrivePieces c = straight_drive("c", 0.0, 0.0, 8);
  show_places(a, 0);
  show_places(b, 60);  // as the last two pieces of a
  show_places(c, 1000);
  const auto chunks = find_chunks({a, b, c});
  ASSERT_EQ(chunks.size(), 2U) << "a and c by their boxes";
  EXPECT_EQ(chunks[0].id, "a--b--000");
  EXPECT_TRUE(chunks[0].by_appearance);
  EXPECT_FALSE(chunks[0].by_position);
  EXPECT_EQ(chunks[0].a_ranges.front().first, 400U) << "two neighbours more";
  EXPECT_EQ(chunks[0].a_ranges.back().last, 799U);
  EXPECT_EQ(chunks[1].id, "a--c--000");
}

TEST(SearchChunks, WrongGnssIsNoticedByAppearance) {
  DrivePieces a = straight_drive("a", 0.0, 0.0, 8), b = straight_drive("b", 9000.0, 0.0, 4);
  show_places(a, 0);
  show_places(b, 0);
  const auto chunks = find_chunks({a, b});
  ASSERT_EQ(chunks.size(), 1U);
  EXPECT_TRUE(chunks[0].by_appearance);
}

TEST(SearchChunks, TheOrderOfRangesIsThatOfKeyFrames) {
  EXPECT_TRUE(contains({{3, 5}, {9, 9}}, 5));
  EXPECT_TRUE(contains({{3, 5}, {9, 9}}, 9));
  EXPECT_FALSE(contains({{3, 5}, {9, 9}}, 6));
  EXPECT_FALSE(contains({}, 0));
}

}  // namespace
}  // namespace lidar_mapping::city::test
