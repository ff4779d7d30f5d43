// SPDX-License-Identifier: BSD-3-Clause
// Entwine Point Tiles, read back by a reader of their specification (read_ept.py).
#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_builder.hpp"

#include "file_content.hpp"
#include "files/ept_file.hpp"
#include "files/millimetre_frame.hpp"
#include "memory_clouds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::files_in;
using test::TemporaryFolder;

constexpr GeodeticDatum kDatum{49.0122945564, 8.4255659229, 119.6359};
constexpr double kTileSize = 50.0;
constexpr float kLargestIntensity = 200.0F;

/// Ground and walls of some streets, `points` in each of `tiles` tiles; a key frame for each tile.
TileSource streets(int tiles, int points) {
  return [=](const TileSink& sink) {
    for (int number = 0; number < tiles; ++number) {
      std::mt19937 random(static_cast<unsigned>(number));
      std::uniform_real_distribution<float> along(0.0F, 50.0F);
      std::uniform_real_distribution<float> up(0.0F, 12.0F);
      std::uniform_real_distribution<float> intensity(0.0F, kLargestIntensity);
      MapTile tile;
      tile.index = {number, -3};
      tile.origin = {kTileSize * number, -3.0 * kTileSize, 0.0};
      for (int i = 0; i < points; ++i) {
        const float x = along(random);
        const float y = i % 3 == 0 ? 20.0F : along(random);
        tile.cloud.points.push_back({x, y, i % 3 == 0 ? up(random) : 0.0F, intensity(random)});
        tile.key_frames.push_back(static_cast<KeyFrameIndex>(number));
      }
      sink(tile);
    }
  };
}

EptOptions options_with(const std::optional<GeodeticDatum>& datum, std::size_t points_in_memory,
                        int threads) {
  EptOptions options;
  options.datum = datum;
  options.origin = [](KeyFrameIndex index) {
    return PointOrigin{from_seconds(1.6e9 + 0.125 * index), static_cast<std::uint16_t>(index / 2)};
  };
  options.octree.points_in_memory = points_in_memory;
  options.octree.threads = threads;
  return options;
}

std::array<double, 3> rounded(const MillimetreFrame& frame, const Eigen::Vector3d& p_map) {
  const auto mm = frame.millimetres(frame.projected(p_map));
  const Eigen::Vector3d& offset = frame.offset();
  return {offset.x() + kMillimetre * mm[0], offset.y() + kMillimetre * mm[1],
          offset.z() + kMillimetre * mm[2]};
}

/// What read_ept.py has to find.
void write_expected(const TileSource& tiles, const EptOptions& options, const fs::path& path) {
  float largest = 0.0F;
  tiles([&](const MapTile& tile) {
    for (const Point& point : tile.cloud.points) largest = std::max(largest, point.intensity);
  });
  MillimetreFrame frame(options.datum);
  tiles([&, is_first = true](const MapTile& tile) mutable {
    if (is_first) frame.set_offset_near(tile.origin);
    is_first = false;
  });
  std::ofstream file(path);
  file << std::fixed << std::setprecision(6);
  tiles([&](const MapTile& tile) {
    for (std::size_t i = 0; i < tile.cloud.size(); ++i) {
      const Point& point = tile.cloud.points[i];
      // In whole millimetres, so that the reader finds the same order.
      for (const double coordinate : rounded(frame, tile.origin + point.position().cast<double>()))
        file << coordinate << ' ';
      const PointOrigin origin = options.origin(tile.key_frames[i]);
      file << std::lround(point.intensity / largest * 65535.0F) << ' ' << origin.drive << ' '
           << to_seconds(origin.stamp) << '\n';
    }
  });
}

/// Writes the tiles into the folder ept of this one and reads them back.
void expect_read_back(const TileSource& tiles, const EptOptions& options, const fs::path& folder) {
  const fs::path ept = folder / "ept";
  const fs::path expected = folder / "expected.txt";
  write_ept(tiles, options, ept);
  write_expected(tiles, options, expected);
  const std::string command = "python3 map/read_ept.py " + ept.string() + " " + expected.string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(Ept, HoldsAllPointsInTheirNodes) {
  const TemporaryFolder folder;
  expect_read_back(streets(6, 20'000), options_with(kDatum, 45'000, 2), folder.path());
}

TEST(Ept, StaysInTheMapFrameWithoutDatum) {
  const TemporaryFolder folder;
  expect_read_back(streets(2, 1000), options_with(std::nullopt, 60'000, 1), folder.path());
  EXPECT_NE(files_in(folder.path() / "ept").at("ept.json").find("\"srs\": {}"), std::string::npos);
}

// Neither the threads nor what is divided on the disk change a byte.
TEST(Ept, HasTheSameBytesForAnyMemoryAndThreads) {
  const TemporaryFolder folder;
  const TileSource tiles = streets(6, 20'000);
  write_ept(tiles, options_with(kDatum, 1'000'000, 1), folder.path() / "whole");
  write_ept(tiles, options_with(kDatum, 45'000, 4), folder.path() / "parts");
  const auto whole = files_in(folder.path() / "whole");
  ASSERT_GT(whole.size(), 5U);
  EXPECT_TRUE(whole == files_in(folder.path() / "parts"));
}

TEST(Ept, SplitsADeepHierarchy) {
  const TemporaryFolder folder;
  // Points 2 mm apart in a corner of a map of 2 km: the tree is eight levels deep there.
  const TileSource tiles = [](const TileSink& sink) {
    MapTile tile;
    tile.cloud.points.push_back({2000.0F, 0.0F, 0.0F, 1.0F});
    for (int i = 0; i < 300; ++i) {
      for (int k = 0; k < 300; ++k) {
        tile.cloud.points.push_back(
            {0.002F * static_cast<float>(i), 0.002F * static_cast<float>(k), 0.0F, 1.0F});
      }
    }
    tile.key_frames.resize(tile.cloud.size());
    sink(tile);
  };
  expect_read_back(tiles, options_with(std::nullopt, 1'000'000, 2), folder.path());
  EXPECT_GT(files_in(folder.path() / "ept" / "ept-hierarchy").size(), 1U);
}

// Nothing tells them apart, so they end up in one node.
TEST(Ept, TakesPointsAtTheSamePlace) {
  const TemporaryFolder folder;
  const TileSource tiles = [](const TileSink& sink) {
    MapTile tile;
    tile.cloud.points.assign(100'000, {1.0F, 2.0F, 3.0F, 4.0F});
    tile.key_frames.resize(tile.cloud.size());
    sink(tile);
  };
  for (const std::size_t in_memory : {std::size_t{10'000}, std::size_t{1'000'000}}) {
    expect_read_back(tiles, options_with(std::nullopt, in_memory, 1),
                     folder.path() / std::to_string(in_memory));
  }
}

TEST(Ept, RefusesAnEmptyMapAndOneTooLarge) {
  const TemporaryFolder folder;
  const EptOptions options = options_with(kDatum, 60'000, 1);
  EXPECT_THROW(write_ept([](const TileSink&) {}, options, folder.path()), InputError);
  const TileSource far = [](const TileSink& sink) {
    MapTile tile;
    tile.cloud.points = {{0.0F, 0.0F, 0.0F, 1.0F}, {3e6F, 0.0F, 0.0F, 1.0F}};
    sink(tile);
  };
  const EptOptions local = options_with(std::nullopt, 60'000, 1);
  EXPECT_THROW(write_ept(far, local, folder.path()), InputError);
}

// The time and the drive of a point are those of the first key frame that saw its voxel.
TEST(BuildTiles, KnowTheKeyFrameOfEachPoint) {
  MemoryClouds clouds;
  clouds.clouds[4] = cloud_of({{0.1F, 0.1F, 0.1F, 1.0F}});
  clouds.clouds[9] = cloud_of({{0.1F, 0.1F, 0.1F, 1.0F}, {5.1F, 0.1F, 0.1F, 1.0F}});
  const KeyFramePoses poses{1, true, {{4, 40, Pose::Identity()}, {9, 90, Pose::Identity()}}};
  const TemporaryFolder folder;
  std::vector<KeyFrameIndex> key_frames;
  build_tiles(poses, clouds, {}, folder.path(), [&](const MapTile& tile) {
    ASSERT_EQ(tile.cloud.size(), tile.key_frames.size());
    key_frames = tile.key_frames;
  });
  EXPECT_EQ(key_frames, (std::vector<KeyFrameIndex>{4, 9}));
}

TEST(UtmWkt, NamesZonesAndPoles) {
  EXPECT_NE(utm_wkt(32633).find("UTM zone 33N"), std::string::npos);
  EXPECT_NE(utm_wkt(32733).find("\"false_northing\",10000000"), std::string::npos);
  EXPECT_NE(utm_wkt(32661).find("Polar_Stereographic"), std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::map
