// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <yaml-cpp/yaml.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_config.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "files/whole_folder.hpp"
#include "map_products.hpp"
#include "memory_clouds.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::number_at;
using test::TemporaryFolder;

constexpr double kTileSize = 20.0;

/// Two tiles; the second lies far away.
std::vector<MapTile> example_tiles() {
  MapTile near{{0, 0}, {0.0, 0.0, 0.0}, {}};
  near.cloud.points = {{1.0F, 2.0F, 3.0F, 10.0F}, {1.001F, 2.0F, 3.0F, 100.0F}};
  MapTile far{{500, -250}, {10'000.0, -5'000.0, 0.0}, {}};
  far.cloud.points = {{19.999F, 0.001F, -1.0F, 50.0F}};
  return {near, far};
}

void pass_example_tiles(const TileSink& sink) {
  for (const MapTile& tile : example_tiles()) sink(tile);
}

/// Coordinates of a point of a LAS file according to its specification.
Eigen::Vector3d las_point(const std::string& las, std::size_t index) {
  const auto begin = number_at<std::uint32_t>(las, 96) + index * number_at<std::uint16_t>(las, 105);
  Eigen::Vector3d p;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    p[i] = number_at<std::int32_t>(las, begin + 4 * axis) * number_at<double>(las, 131 + 8 * axis) +
           number_at<double>(las, 155 + 8 * axis);
  }
  return p;
}

TEST(WriteTiles, WritesAutowaresLayout) {
  const TemporaryFolder folder;
  const fs::path directory = folder.path() / "pointcloud_map";
  const Files files = write_tiles(pass_example_tiles, kTileSize, directory);
  ASSERT_EQ(files.size(), 3U);
  const YAML::Node yaml = YAML::LoadFile((directory / "pointcloud_map_metadata.yaml").string());
  EXPECT_EQ(yaml["x_resolution"].as<double>(), kTileSize);
  EXPECT_EQ(yaml["10000_-5000.pcd"][1].as<double>(), -5000.0);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((directory / "10000_-5000.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud[0].x, 10'019.999, 1e-3);
  EXPECT_EQ(write_tiles(pass_example_tiles, kTileSize, directory).size(), 3U)
      << "one's own are replaced";
  std::ofstream(folder.path() / "foreign") << "x";
  EXPECT_THROW(write_tiles(pass_example_tiles, kTileSize, folder.path()), FileError);
  EXPECT_TRUE(fs::exists(folder.path() / "foreign"));
}

TEST(WholeFolder, IsNotThereAfterAnyException) {
  const TemporaryFolder folder;
  const auto fail = [](const fs::path& part) {
    std::ofstream(part / "file") << "x";
    throw std::out_of_range("a loop of no key frame");
  };
  EXPECT_THROW(write_whole_folder(folder.path() / "ept", "ept.json", "tiles", fail),
               std::out_of_range);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

// A kill between the two renames leaves the older folder aside and none in its place.
TEST(WholeFolder, IsPutBackAfterAKillWhileItWasReplaced) {
  const TemporaryFolder folder;
  const fs::path ept = folder.path() / "ept", old = folder.path() / ".ept.old";
  const auto written = [](const std::string& text) {
    return [text](const fs::path& part) { std::ofstream(part / "ept.json") << text; };
  };
  write_whole_folder(ept, "ept.json", "tiles", written("first"));
  fs::rename(ept, old);
  const auto fail = [](const fs::path&) { throw std::out_of_range("a full disk"); };
  EXPECT_THROW(write_whole_folder(ept, "ept.json", "tiles", fail), std::out_of_range);
  EXPECT_EQ(content_of(ept / "ept.json"), "first");
  EXPECT_FALSE(fs::exists(old));
  fs::rename(ept, old);
  write_whole_folder(ept, "ept.json", "tiles", written("second"));
  EXPECT_EQ(content_of(ept / "ept.json"), "second");
  EXPECT_FALSE(fs::exists(old));
}

// Two points that are far apart would make a picture that no disk holds.
TEST(WriteGrid, RefusesMoreCellsThanAPictureCanHave) {
  const TemporaryFolder folder;
  PointCloud map;
  map.points = {{0.0F, 0.0F, 0.0F, 0.0F}, {40'000.0F, 30'000.0F, 0.0F, 0.0F}};
  GridOptions options;
  options.cell = 0.1;
  const std::string problem =
      test::error_text<InputError>([&] { write_grid(map, options, folder.path(), std::nullopt); });
  EXPECT_NE(problem.find("give a larger --cell"), std::string::npos) << problem;
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

// Coordinates of the LAS file are right to a millimetre, in UTM and in the map frame.
TEST(WriteLas, CoordinatesAreAccurateToAMillimetre) {
  const TemporaryFolder folder;
  const GeodeticDatum datum{48.98, 8.39, 116.5};
  write_las(folder.path() / "map.las", pass_example_tiles, datum, 100.0F);
  const std::string las = content_of(folder.path() / "map.las");
  ASSERT_EQ(las.substr(0, 4), "LASF");
  ASSERT_EQ(number_at<std::uint32_t>(las, 107), 3U);
  ASSERT_EQ(las.size(), number_at<std::uint32_t>(las, 96) + 3U * 20U);
  const GeographicLib::LocalCartesian local(datum.latitude_deg, datum.longitude_deg,
                                            datum.altitude_m);
  std::size_t index = 0;
  for (const MapTile& tile : example_tiles()) {
    for (const Point& point : tile.cloud.points) {
      const Eigen::Vector3d p = tile.origin + point.position().cast<double>();
      double latitude, longitude, height, x, y;
      int zone;
      bool north;
      local.Reverse(p.x(), p.y(), p.z(), latitude, longitude, height);
      GeographicLib::UTMUPS::Forward(latitude, longitude, zone, north, x, y);
      EXPECT_TRUE(test::near(las_point(las, index++), Eigen::Vector3d(x, y, height), 0.001));
      EXPECT_EQ(zone, 32);
    }
  }
  // Readers use the bounds of the header, so no point may lie beyond them by its rounding.
  for (std::size_t i = 0; i < index; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto bound = static_cast<std::size_t>(179 + 16 * axis);
      EXPECT_LE(las_point(las, i)[axis], number_at<double>(las, bound));
      EXPECT_GE(las_point(las, i)[axis], number_at<double>(las, bound + 8));
    }
  }
  EXPECT_EQ(number_at<std::uint16_t>(las, 227 + 54 + 22), 32632) << "EPSG code";
  EXPECT_EQ(number_at<std::uint16_t>(las, number_at<std::uint32_t>(las, 96) + 32), 65535);
}

TEST(WriteLas, UsesMapFrameWithoutDatum) {
  const TemporaryFolder folder;
  write_las(folder.path() / "map.las", pass_example_tiles, std::nullopt, 100.0F);
  const std::string las = content_of(folder.path() / "map.las");
  EXPECT_EQ(number_at<std::uint32_t>(las, 100), 0U) << "no georeference";
  EXPECT_TRUE(test::near(las_point(las, 2), Eigen::Vector3d(10'019.999, -4'999.999, -1.0), 0.001));
  EXPECT_NEAR(number_at<double>(las, 179), 10'019.999, 1e-3) << "largest x";
  EXPECT_NEAR(number_at<double>(las, 187), 1.0, 1e-3) << "smallest x";
}

TEST(WriteGrid, MarksObstaclesAboveTheLocalGround) {
  const TemporaryFolder folder;
  PointCloud map;
  for (int i = 0; i < 400; ++i) {
    const float x = 0.1F * static_cast<float>(i % 20) + 0.05F;
    const float y = 0.1F * static_cast<float>(i / 20) + 0.05F;
    const float ground = 10.0F + 0.1F * x;
    map.points.push_back({x, y, ground, 0.0F});
    if (i % 20 == 15) {
      map.points.push_back({x, y, ground + 1.0F, 0.0F});
      map.points.push_back({x, y, ground + 1.5F, 0.0F});
    }
    if (i % 20 == 5) map.points.push_back({x, y, ground + 3.0F, 0.0F});
  }
  write_grid(map, {0.1}, folder.path());
  const std::string pgm = content_of(folder.path() / "grid.pgm");
  const std::size_t begin = pgm.find("255\n") + 4;
  ASSERT_EQ(pgm.substr(0, 3), "P5\n");
  const auto value = [&](std::size_t column) {
    return static_cast<unsigned char>(pgm[begin + 10 * 20 + column]);
  };
  EXPECT_EQ(value(15), 0) << "a wall";
  EXPECT_EQ(value(2), 254) << "free ground";
  EXPECT_EQ(value(5), 254) << "a bridge is no obstacle";
  const YAML::Node yaml = YAML::LoadFile((folder.path() / "grid.yaml").string());
  EXPECT_EQ(yaml["resolution"].as<double>(), 0.1);
  EXPECT_NEAR(yaml["origin"][0].as<double>(), 0.0, 1e-6);
}

/// Value of the cell of 0.2 m at x in the row along y = 0.1 m.
int cell_value_at(const fs::path& folder, double x) {
  const std::string pgm = content_of(folder / "grid.pgm");
  int columns = 0;
  int rows = 0;
  std::istringstream(pgm.substr(3)) >> columns >> rows;
  const YAML::Node yaml = YAML::LoadFile((folder / "grid.yaml").string());
  const int column = static_cast<int>((x - yaml["origin"][0].as<double>()) / 0.2);
  const int row = static_cast<int>((0.1 - yaml["origin"][1].as<double>()) / 0.2);
  const std::size_t begin = pgm.find("255\n") + 4;
  return static_cast<unsigned char>(
      pgm[begin + static_cast<std::size_t>((rows - 1 - row) * columns + column)]);
}

// Ground up to 4 m, a pole at 6 m, a wall at 12 m and ground behind it; rays reach the wall. There
// are no points of the ground between 4 and 7 m, but the ground around is known.
TEST(WriteGrid, MarksCellsFreeWhereRaysPassed) {
  const TemporaryFolder folder;
  PointCloud map;
  for (int i = 0; i < 160; ++i) {
    const float x = 0.1F * static_cast<float>(i) + 0.05F;
    if (x > 4.0F && x < 7.0F) continue;
    for (const float y : {-0.35F, -0.15F, 0.05F, 0.25F}) {
      map.points.push_back({x, y, 0.0F, 0.0F});
      map.points.push_back({x, y, 0.01F, 0.0F});
    }
  }
  std::vector<Point> observed;
  for (const float z : {0.5F, 0.7F, 0.9F, 1.1F}) {
    map.points.push_back({6.1F, 0.1F, z, 0.0F});
    map.points.push_back({12.1F, 0.1F, z, 0.0F});
    observed.push_back({12.1F, 0.1F, z, 0.0F});
  }
  MemoryClouds clouds;
  clouds.clouds[0] = cloud_of(observed);
  KeyFramePoses poses;
  poses.poses.push_back({0, 0, Pose()});
  const Eigen::Vector3d p_base_sensor(0.0, 0.1, 1.7);

  write_grid(map, {}, folder.path());
  EXPECT_EQ(cell_value_at(folder.path(), 5.1), 205) << "no ray, no knowledge";
  write_grid(map, {}, folder.path(), GridRays{poses, clouds, p_base_sensor});
  EXPECT_EQ(cell_value_at(folder.path(), 2.1), 254) << "ground";
  EXPECT_EQ(cell_value_at(folder.path(), 5.1), 254) << "a ray passed";
  EXPECT_EQ(cell_value_at(folder.path(), 6.1), 0) << "rays that pass a pole leave it";
  EXPECT_EQ(cell_value_at(folder.path(), 12.1), 0) << "the wall that they end at";
  const Eigen::Vector3d high(0.0, 0.1, 40.0);
  write_grid(map, {}, folder.path(), GridRays{poses, clouds, high});
  EXPECT_EQ(cell_value_at(folder.path(), 5.1), 205) << "far above a vehicle";
}

// Ground up to the border of a square of 400 m, and none in the next one, which lies inside of the
// grid because of the square behind it. A ray passes on over the border.
TEST(WriteGrid, UsesTheGroundBeyondTheBorderOfABlock) {
  const TemporaryFolder folder;
  PointCloud map;
  map.points.push_back({0.05F, 0.1F, 0.0F, 0.0F});
  for (int i = 0; i < 100; ++i) {
    const float x = 390.0F + 0.1F * static_cast<float>(i) + 0.05F;
    for (const float y : {-0.35F, -0.15F, 0.05F, 0.25F}) {
      map.points.push_back({x, y, 0.0F, 0.0F});
      map.points.push_back({x, y, 0.01F, 0.0F});
    }
  }
  map.points.push_back({900.05F, 0.1F, 0.0F, 0.0F});
  MemoryClouds clouds;
  std::vector<Point> observed;
  observed.push_back({40.0F, 0.1F, 0.5F, 0.0F});
  clouds.clouds[0] = cloud_of(observed);
  KeyFramePoses poses;
  poses.poses.push_back({0, 0, Pose{Eigen::Quaterniond::Identity(), {390.0, 0.0, 0.0}}});
  const Eigen::Vector3d p_base_sensor(0.0, 0.1, 1.7);
  write_grid(map, {}, folder.path(), GridRays{poses, clouds, p_base_sensor});
  EXPECT_EQ(cell_value_at(folder.path(), 395.1), 254) << "ground";
  EXPECT_EQ(cell_value_at(folder.path(), 401.1), 254) << "the ray passed beside known ground";
  EXPECT_EQ(cell_value_at(folder.path(), 406.1), 205) << "no ground is known";
}

TEST(GridCell, RejectsCellsSmallerThanVoxels) {
  MapConfig config;
  EXPECT_EQ(grid_cell(config), config.resolution);
  config.grid_cell = 0.5;
  EXPECT_EQ(grid_cell(config), 0.5);
  config.grid_cell = 0.1;
  EXPECT_THROW(grid_cell(config), InputError);
}

// 25 million cells are more than are in memory at a time.
TEST(WriteGrid, BlocksGiveTheSameGrid) {
  const TemporaryFolder folder;
  PointCloud map;
  for (int i = 0; i < 100 * 100; ++i) {
    const float x = 0.5F * static_cast<float>(i % 100) + 0.25F;
    const float y = 0.5F * static_cast<float>(i / 100) + 0.25F;
    map.points.push_back({x, y, 0.0F, 0.0F});
    map.points.push_back({x, y, 0.01F, 0.0F});
    map.points.push_back({x, y, 1.0F, 0.0F});
    map.points.push_back({x, y, 1.1F, 0.0F});
  }
  const CloudParts halves([&](const CloudParts::Sink& sink) {
    const auto middle = map.points.begin() + 20'000;
    sink({{map.points.begin(), middle}, {}});
    sink({{middle, map.points.end()}, {}});
  });
  write_grid(halves, {0.01}, folder.path());
  const std::string pgm = content_of(folder.path() / "grid.pgm");
  const std::string pixels = pgm.substr(pgm.find("255\n") + 4);
  EXPECT_EQ(std::count(pixels.begin(), pixels.end(), '\0'), 100 * 100);
  EXPECT_EQ(std::count(pixels.begin(), pixels.end(), '\xfe'), 0);
}

// A road of 1600 m, 100 m in each part.
TEST(WriteGrid, ReadsOnlyThePartsAroundEachBlock) {
  const TemporaryFolder folder;
  std::vector<PointCloud> road(16);
  for (std::size_t i = 0; i < 3200; ++i) {
    const float x = 0.5F * static_cast<float>(i) + 0.25F;
    road[i / 200].points.push_back({x, 0.1F, 0.0F, 0.0F});
    road[i / 200].points.push_back({x, 0.1F, 0.01F, 0.0F});
  }
  const auto tiles = [&](const TileSink& sink) {
    for (std::size_t i = 0; i < road.size(); ++i) {
      sink({{static_cast<int>(i), 0}, {0.0, 0.0, 0.0}, road[i]});
    }
  };
  const CloudParts stored = stored_parts(tiles, folder.path());
  std::size_t parts_read = 0;
  const CloudParts counted([&](const CloudParts::Sink& sink) { stored.for_each(sink); },
                           [&](const CloudParts::Area& area, const CloudParts::Sink& sink) {
                             stored.for_each_near(area, [&](const PointCloud& part) {
                               ++parts_read;
                               sink(part);
                             });
                           });
  write_grid(counted, {}, folder.path());
  EXPECT_GE(parts_read, 16U) << "all are needed";
  EXPECT_LE(parts_read, 16U + 6U) << "and those beside the three borders twice";
  const std::string by_parts = content_of(folder.path() / "grid.pgm");
  const CloudParts whole([&](const CloudParts::Sink& sink) { stored.for_each(sink); });
  write_grid(whole, {}, folder.path());
  EXPECT_EQ(content_of(folder.path() / "grid.pgm"), by_parts);
}

}  // namespace
}  // namespace lidar_mapping::map
