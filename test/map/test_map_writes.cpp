// SPDX-License-Identifier: BSD-3-Clause
// The folder of a map after a kill or on a full disk, and as an independent reader sees it.

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <thread>

#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/top_view.hpp"
#include "lidar_mapping/map/write_products.hpp"

#include "file_content.hpp"
#include "map_formats.hpp"
#include "map_products.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::number_at;
using test::TemporaryFolder;

constexpr double kTileSize = 20.0;
constexpr int kTiles = 4;

MapTile example_tile(int number, const Eigen::Vector3d& corner, int points) {
  MapTile tile{{number, 0}, corner + Eigen::Vector3d(kTileSize * number, 0.0, 0.0), {}};
  for (int i = 0; i < points; ++i) {
    tile.cloud.points.push_back({0.001F * static_cast<float>(i % 19'000),
                                 0.01F * static_cast<float>(i % 7),
                                 0.1F * static_cast<float>(number), static_cast<float>(i % 200)});
  }
  return tile;
}

/// Tiles in a row with `points` points each.
TileSource row_of_tiles(const Eigen::Vector3d& corner, int points) {
  return [=](const TileSink& sink) {
    for (int number = 0; number < kTiles; ++number) sink(example_tile(number, corner, points));
  };
}

PointCloud cloud_of(int points) {
  PointCloud cloud;
  row_of_tiles(Eigen::Vector3d::Zero(), points / kTiles)([&](const MapTile& tile) {
    for (Point point : tile.cloud.points) {
      point.x += static_cast<float>(tile.origin.x());
      cloud.points.push_back(point);
    }
  });
  return cloud;
}

void write_all(const fs::path& directory, int points) {
  const PointCloud cloud = cloud_of(points);
  const TileSource tiles = row_of_tiles(Eigen::Vector3d::Zero(), points / kTiles);
  write_point_files(cloud, {}, directory, point_formats());
  write_las(directory / "map.las", tiles, std::nullopt, 200.0F);
  write_tiles(tiles, kTileSize, directory / "pointcloud_map");
  write_grid(cloud, {}, directory);
  write_png(directory / "top_view.png", top_view(cloud, 0.5));
}

// An independent reader reads every product according to its published format, also if the map
// frame is as far away as UTM coordinates.
TEST(MapProducts, IndependentReaderReadsThem) {
  const TemporaryFolder folder;
  const Eigen::Vector3d far(432'000.0, 5'412'000.0, 0.0);
  write_all(folder.path(), 400);
  const TileSource tiles = row_of_tiles(far, 100);
  write_las(folder.path() / "map.las", tiles, std::nullopt, 200.0F);
  std::ofstream points(folder.path() / "points.txt");
  points << std::fixed << std::setprecision(6);
  tiles([&](const MapTile& tile) {
    for (const Point& point : tile.cloud.points) {
      points << (tile.origin + point.position().cast<double>()).transpose() << "\n";
    }
  });
  points.close();
  const std::string command = "python3 map/read_map_products.py " + folder.path().string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

// Floats cannot hold such coordinates; no file is better than a wrong one.
TEST(MapProducts, RejectFloatsFarFromTheOrigin) {
  const TemporaryFolder folder;
  PointCloud far;
  far.points = {{432'000.0F, 5'412'000.0F, 0.0F, 0.0F}};
  EXPECT_THROW(write_point_files(far, {}, folder.path(), {}), InputError);
  for (const std::string& format : point_formats()) {
    EXPECT_THROW(find_format(format)->write_points(folder.path() / "part", far), InputError)
        << format;
  }
  const Eigen::Vector3d corner(432'000.0, 5'412'000.0, 0.0);
  EXPECT_THROW(write_tiles(row_of_tiles(corner, 10), kTileSize, folder.path() / "tiles"),
               InputError);
  EXPECT_FALSE(fs::exists(folder.path() / "tiles"));
}

/// Every file with its final name is complete.
void expect_complete(const fs::path& directory, std::size_t points) {
  pcl::PointCloud<pcl::PointXYZI> cloud;
  if (fs::exists(directory / "map.pcd")) {
    EXPECT_EQ(pcl::io::loadPCDFile((directory / "map.pcd").string(), cloud), 0);
    EXPECT_EQ(cloud.size(), points);
  }
  if (fs::exists(directory / "map.ply")) {
    EXPECT_EQ(pcl::io::loadPLYFile((directory / "map.ply").string(), cloud), 0);
    EXPECT_EQ(cloud.size(), points);
  }
  if (fs::exists(directory / "map.las")) {
    const std::string las = content_of(directory / "map.las");
    ASSERT_EQ(las.size(), 227 + 20 * points);
    EXPECT_EQ(number_at<std::uint32_t>(las, 107), points);
  }
  if (fs::exists(directory / "pointcloud_map")) {
    std::size_t in_tiles = 0;
    for (int number = 0; number < kTiles; ++number) {
      const auto name = std::to_string(20 * number) + "_0.pcd";
      ASSERT_EQ(pcl::io::loadPCDFile((directory / "pointcloud_map" / name).string(), cloud), 0);
      in_tiles += cloud.size();
    }
    EXPECT_EQ(in_tiles, points);
  }
}

/// The files of points that are there are those of the other folder.
void expect_same_points(const fs::path& directory, const fs::path& whole) {
  for (const std::string& format : point_formats()) {
    const std::string name = "map." + format;
    if (!fs::exists(directory / name)) continue;
    EXPECT_TRUE(content_of(directory / name) == content_of(whole / name)) << name;
  }
}

// After a kill at any moment all files are complete, and the next run succeeds.
TEST(MapProducts, StayCompleteAfterKillAtAnyMoment) {
  constexpr int kPoints = 40'000;
  const TemporaryFolder whole;
  write_all(whole.path(), kPoints);
  const TemporaryFolder folder;
  for (int round = 0; round < 10; ++round) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      while (true) write_all(folder.path(), kPoints);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(3 + 17 * round));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    expect_complete(folder.path(), kPoints);
    expect_same_points(folder.path(), whole.path());
  }
  write_all(folder.path(), kPoints);
  expect_complete(folder.path(), kPoints);
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

/// Returns 0 (the exit status of success) if every product reports with its name that it could not
/// be written.
int write_to_a_full_disk(const fs::path& directory) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{20'000, 20'000};  // bytes a file
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const PointCloud cloud = cloud_of(100'000);
  const TileSource tiles = row_of_tiles(Eigen::Vector3d::Zero(), 25'000);
  std::vector<std::pair<std::string, std::function<void()>>> writes = {
      {"map.las", [&] { write_las(directory / "map.las", tiles, std::nullopt, 200.0F); }},
      {"0_0.pcd", [&] { write_tiles(tiles, kTileSize, directory / "pointcloud_map"); }},
      {"grid.pgm", [&] { write_grid(cloud, {0.01}, directory); }}};
  for (const std::string& format : point_formats()) {
    const std::string name = "map." + format;
    writes.emplace_back(
        name, [&, format, name] { find_format(format)->write_points(directory / name, cloud); });
  }
  int silent = 0;
  for (const auto& [name, write] : writes) {
    try {
      write();
      ++silent;
    } catch (const FileError& error) {
      if (std::strstr(error.what(), name.c_str()) == nullptr) ++silent;
    }
  }
  return silent;
}

// A full disk is an error that names the file; the older map stays.
TEST(MapProducts, ReportFullDiskAndKeepOldMap) {
  const TemporaryFolder folder;
  write_all(folder.path(), 4000);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(write_to_a_full_disk(folder.path()));
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "products that failed without a word or a name";
  expect_complete(folder.path(), 4000);
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
  }
}

}  // namespace
}  // namespace lidar_mapping::map
