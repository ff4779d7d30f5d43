// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "city_files.hpp"
#include "error_text.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::city::test {
namespace {

using lidar_mapping::test::TemporaryFolder;

TEST(CityFiles, PiecesComeBack) {
  const TemporaryFolder folder;
  DrivePieces drive;
  drive.drive = "monday";
  drive.pieces.resize(2);
  drive.pieces[0].last = 7;
  drive.pieces[0].box.emplace(Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d(4.1, 5.0, 6.0));
  drive.pieces[1].places.resize(1);
  drive.pieces[1].places[0][3] = 200;
  write_pieces(drive, folder.path() / "pieces.json");
  const DrivePieces back = read_pieces(folder.path() / "pieces.json");
  EXPECT_EQ(back.drive, "monday");
  ASSERT_EQ(back.pieces.size(), 2U);
  EXPECT_EQ(back.pieces[0].box->max(), drive.pieces[0].box->max());
  EXPECT_FALSE(back.pieces[1].box);
  EXPECT_EQ(back.pieces[1].places, drive.pieces[1].places);
}

TEST(CityFiles, LoopsComeBackToTheLastBit) {
  const TemporaryFolder folder;
  PairLoops pair;
  pair.a = "a";
  pair.b = "b";
  pair.used_gnss = true;
  pair.searched = 12;
  Loop loop;
  loop.from = 3;
  loop.to = 8;
  loop.stamp = 1'700'000'000'123'456'789;
  loop.T_from_to.translation = {1.0 / 3.0, -2e-7, 5.5};
  loop.T_from_to.rotation = Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized();
  loop.covariance(0, 5) = 1e-9;
  loop.source = LoopSource::kAppearance;
  pair.loops.push_back(loop);
  pair.verdicts.resize(1);
  pair.verdicts[0].reason = "too \"far\"";
  write_loops(pair, folder.path() / "loops.json");
  const PairLoops back = read_loops(folder.path() / "loops.json");
  ASSERT_EQ(back.loops.size(), 1U);
  EXPECT_EQ(back.loops[0].stamp, loop.stamp);
  EXPECT_EQ(back.loops[0].T_from_to.translation, loop.T_from_to.translation);
  EXPECT_EQ(back.loops[0].T_from_to.rotation.coeffs(), loop.T_from_to.rotation.coeffs());
  EXPECT_EQ(back.loops[0].covariance, loop.covariance);
  EXPECT_EQ(back.loops[0].source, LoopSource::kAppearance);
  EXPECT_EQ(back.verdicts[0].reason, pair.verdicts[0].reason);
  EXPECT_TRUE(back.used_gnss);
}

TEST(CityFiles, ChunksComeBackFromAFileForEach) {
  const TemporaryFolder folder;
  Chunk chunk;
  chunk.id = "a--b--000";
  chunk.a = "a";
  chunk.b = "b";
  chunk.a_ranges = {{0, 5}, {9, 12}};
  chunk.b_ranges = {{2, 3}};
  chunk.by_appearance = true;
  write_chunks({chunk}, folder.path() / "pairs");
  const Chunk back = read_chunk(folder.path() / "pairs/a--b--000.json");
  ASSERT_EQ(back.a_ranges.size(), 2U);
  EXPECT_EQ(back.a_ranges[1].last, 12U);
  EXPECT_TRUE(back.by_appearance);
  EXPECT_FALSE(back.by_position);
}

/// What the function says about a file with this text.
template <typename Read>
std::string complaint(const std::filesystem::path& path, const std::string& text,
                      const Read& read) {
  std::ofstream(path) << text;
  return lidar_mapping::test::error_text<InputError>([&] { read(path); });
}

TEST(CityFiles, DamagedFilesAreNamedWithTheRemedy) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "x.json";
  for (const char* text : {"", "{", "[]", "{\"a\": 3}", "{\"drive\": \"a\", \"pieces\": [{}]}"}) {
    const std::string pieces = complaint(path, text, read_pieces);
    EXPECT_NE(pieces.find("x.json"), std::string::npos) << text;
    EXPECT_NE(pieces.find("delete it"), std::string::npos) << text;
    EXPECT_FALSE(complaint(path, text, read_chunk).empty()) << text;
    EXPECT_FALSE(complaint(path, text, read_loops).empty()) << text;
  }
  const std::string digits = complaint(
      path, R"({"drive": "a", "pieces": [{"first": 0, "last": 1, "box": null, "places": ["0x"]}]})",
      read_pieces);
  EXPECT_NE(digits.find("digits"), std::string::npos) << digits;
  EXPECT_NE(digits.find("x.json"), std::string::npos) << digits;
  const std::string source =
      complaint(path, R"({"a": "a", "b": "b", "used_gnss": true, "searched": 1, "loops": [],
               "verdicts": [{"from": 0, "to": 1, "source": "rumour"}]})",
                read_loops);
  EXPECT_NE(source.find("x.json"), std::string::npos) << source;
  EXPECT_THROW(read_chunk(folder.path() / "none.json"), FileError);
}

}  // namespace
}  // namespace lidar_mapping::city::test
