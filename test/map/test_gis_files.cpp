// SPDX-License-Identifier: BSD-3-Clause
// GeoTIFF and GeoJSON, read back by GDAL (read_gis_files.py).
#include <fstream>
#include <iomanip>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/write_products.hpp"

#include "file_content.hpp"
#include "files/millimetre_frame.hpp"
#include "gis/geotiff_files.hpp"
#include "map_products.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::TemporaryFolder;

constexpr GeodeticDatum kDatum{49.0122945564, 8.4255659229, 119.6359};
constexpr int kSkipped = 77;  // of read_gis_files.py: nothing was read

void pass_points(const TileSink& sink) {
  for (int number = 0; number < 3; ++number) {
    std::mt19937 random(static_cast<unsigned>(number));
    std::uniform_real_distribution<float> place(0.0F, 50.0F);
    MapTile tile;
    tile.index = {number, 0};
    tile.origin = {50.0 * number, 0.0, 0.0};
    for (int i = 0; i < 4000; ++i) {
      tile.cloud.points.push_back({place(random), place(random), place(random), place(random)});
    }
    sink(tile);
  }
}

void write_expected(const std::optional<GeodeticDatum>& datum, const fs::path& path) {
  const MillimetreFrame frame(datum);
  std::ofstream file(path);
  file << std::fixed << std::setprecision(6);
  pass_points([&](const MapTile& tile) {
    for (const Point& point : tile.cloud.points) {
      // The file holds whole millimetres, which decide in which pixel a point at a border is.
      const auto mm =
          frame.millimetres(frame.projected(tile.origin + point.position().cast<double>()));
      for (std::size_t i = 0; i < 3; ++i) {
        file << frame.offset()[static_cast<Eigen::Index>(i)] + kMillimetre * mm[i] << ' ';
      }
      file << point.intensity << '\n';
    }
  });
}

/// Runs the reader; a test without GDAL's Python module is skipped loudly.
void expect_read(const std::string& arguments) {
  const int status = std::system(("python3 map/read_gis_files.py " + arguments).c_str());
  if (WEXITSTATUS(status) == kSkipped) GTEST_SKIP() << "python3-gdal is not installed";
  EXPECT_EQ(status, 0) << arguments;
}

class GeoTiff : public testing::Test {
 protected:
  void SetUp() override {
    if (!geotiff_obstacle().empty()) GTEST_SKIP() << geotiff_obstacle();
  }
  const TemporaryFolder folder_;
};

TEST_F(GeoTiff, IsInTheZoneOfTheDatum) {
  const Files files = write_geotiff(pass_points, kDatum, 0.5, folder_.path());
  EXPECT_EQ(files.size(), 3U);
  const fs::path expected = folder_.path() / "expected.txt";
  write_expected(kDatum, expected);
  expect_read("geotiff " + folder_.path().string() + " 32632 " + expected.string() + " 0.5");
}

TEST_F(GeoTiff, IsInTheMapFrameWithoutDatum) {
  write_geotiff(pass_points, std::nullopt, 1.0, folder_.path());
  const fs::path expected = folder_.path() / "expected.txt";
  write_expected(std::nullopt, expected);
  expect_read("geotiff " + folder_.path().string() + " 0 " + expected.string() + " 1.0");
}

TEST_F(GeoTiff, RefusesARasterTooLarge) {
  const TileSource far = [](const TileSink& sink) {
    MapTile tile;
    tile.cloud.points = {{0.0F, 0.0F, 0.0F, 1.0F}, {90'000.0F, 90'000.0F, 0.0F, 1.0F}};
    sink(tile);
  };
  EXPECT_THROW(write_geotiff(far, std::nullopt, 0.1, folder_.path()), InputError);
  EXPECT_THROW(write_geotiff([](const TileSink&) {}, std::nullopt, 0.1, folder_.path()),
               InputError);
  EXPECT_TRUE(fs::is_empty(folder_.path())) << "nothing is left";
}

DriveMarks example_marks() {
  DriveMarks marks;
  for (KeyFrameIndex i = 0; i < 6; ++i) {
    marks.path.push_back({i, i / 3, from_seconds(100.0 + i), {10.0 * i, 0.0, 1.0}});
  }
  marks.loops = {{0, 4, Verdict::kAccepted, "the graph agrees", LoopSource::kPosition}};
  DoubtMark doubt;
  doubt.kind = "lost";
  doubt.expected_error = std::numeric_limits<double>::infinity();
  doubt.is_trusted = false;
  doubt.path_map = {{1.0, 2.0, 3.0}};
  marks.doubts = {doubt};
  return marks;
}

nlohmann::json json_in(const fs::path& path) { return nlohmann::json::parse(content_of(path)); }

TEST(GeoJson, IsInDegreesWithADatum) {
  const TemporaryFolder folder;
  EXPECT_EQ(write_geojson(example_marks(), kDatum, folder.path()).size(), 3U);
  const auto path = json_in(folder.path() / "trajectory.geojson");
  ASSERT_EQ(path["features"].size(), 2U) << "a line for each drive";
  const auto& first = path["features"][0];
  EXPECT_EQ(first["geometry"]["type"], "LineString");
  EXPECT_EQ(first["properties"]["length_m"], 20.0);
  const auto& position = first["geometry"]["coordinates"][0];
  EXPECT_NEAR(position[0].get<double>(), kDatum.longitude_deg, 1e-9);
  EXPECT_NEAR(position[1].get<double>(), kDatum.latitude_deg, 1e-9);
  EXPECT_NEAR(position[2].get<double>(), kDatum.altitude_m + 1.0, 1e-3);
  // 20 m east, along the parallel of 49 degrees (WGS 84: 73.1 km for a degree there).
  EXPECT_NEAR(first["geometry"]["coordinates"][2][0].get<double>() - position[0].get<double>(),
              20.0 / 73'160.0, 1e-7);
  const auto doubt = json_in(folder.path() / "doubt.geojson")["features"][0];
  EXPECT_EQ(doubt["geometry"]["type"], "Point");
  EXPECT_TRUE(doubt["properties"]["expected_error_m"].is_null()) << "nobody knows it";
  EXPECT_EQ(doubt["properties"]["trusted"], false);
  EXPECT_EQ(json_in(folder.path() / "loops.geojson")["features"][0]["properties"]["verdict"],
            "accepted");
  expect_read("geojson " + folder.path().string() + " 2 1 1");
}

TEST(GeoJson, SaysThatItIsLocalWithoutADatum) {
  const TemporaryFolder folder;
  const Files files = write_geojson(example_marks(), std::nullopt, folder.path());
  EXPECT_EQ(files[0].filename(), "trajectory_local_metres.geojson");
  const auto path = json_in(files[0]);
  EXPECT_EQ(path["frame"], "metres in the frame of the map, not WGS 84");
  // Members that RFC 7946 (7.1) forbids in a collection.
  for (const char* member : {"coordinates", "geometries", "geometry", "properties"}) {
    EXPECT_FALSE(path.contains(member)) << member;
  }
  EXPECT_EQ(path["features"][1]["geometry"]["coordinates"][2][0], 50.0);
}

}  // namespace
}  // namespace lidar_mapping::map
