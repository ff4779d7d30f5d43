// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>
#include <yaml-cpp/yaml.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/map/top_view.hpp"

#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

PointCloud example_map() {
  PointCloud map;
  for (int i = 0; i < 1000; ++i) {
    const auto value = static_cast<float>(i);
    map.points.push_back({0.1F * value, -0.05F * value, 0.01F * value, value});
  }
  return map;
}

template <typename Cloud>
void expect_example(const Cloud& cloud) {
  const PointCloud map = example_map();
  ASSERT_EQ(cloud.size(), map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_EQ(cloud[i].x, map.points[i].x);
    EXPECT_EQ(cloud[i].z, map.points[i].z);
    EXPECT_EQ(cloud[i].intensity, map.points[i].intensity);
  }
}

TEST(WritePointFiles, WritesFilesThatPclReadsBack) {
  const TemporaryFolder folder;
  const Files files = write_point_files(example_map(), {}, folder.path() / "map", {});
  EXPECT_EQ(files.size(), 3U);
  for (const fs::path& file : files) EXPECT_TRUE(fs::is_regular_file(file)) << file;
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((folder.path() / "map/map.pcd").string(), cloud), 0);
  expect_example(cloud);
  ASSERT_EQ(pcl::io::loadPLYFile((folder.path() / "map/map.ply").string(), cloud), 0);
  expect_example(cloud);
}

// Larger maps are not compressed, so that they need not be in memory as a whole.
TEST(WritePointFiles, WritesLargeMapsInParts) {
  constexpr std::size_t kPart = 300'000;
  constexpr std::size_t kParts = 8;
  const CloudParts parts([](const CloudParts::Sink& sink) {
    PointCloud part;
    for (std::size_t i = 0; i < kParts; ++i) {
      part.points.assign(kPart, {static_cast<float>(i), 2.0F, 3.0F, 4.0F});
      sink(part);
    }
  });
  const TemporaryFolder folder;
  write_point_files(parts, {}, folder.path(), {});
  const auto expect_whole = [&](const pcl::PointCloud<pcl::PointXYZI>& cloud) {
    ASSERT_EQ(cloud.size(), kParts * kPart);
    EXPECT_EQ(cloud[kPart - 1].x, 0.0F);
    EXPECT_EQ(cloud[7 * kPart].x, 7.0F);
    EXPECT_EQ(cloud.back().intensity, 4.0F);
  };
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((folder.path() / "map.pcd").string(), cloud), 0);
  expect_whole(cloud);
  ASSERT_EQ(pcl::io::loadPLYFile((folder.path() / "map.ply").string(), cloud), 0);
  expect_whole(cloud);
}

// map.yaml holds frame, origin, voxel size and bounds of the map.
TEST(WritePointFiles, WritesDescriptionBesideMap) {
  const TemporaryFolder folder;
  MapDescription description;
  description.datum = GeodeticDatum{48.1234567891, 11.5, 520.25};
  description.resolution = 0.1;
  write_point_files(example_map(), description, folder.path(), {"pcd"});
  EXPECT_FALSE(fs::exists(folder.path() / "map.ply"));
  const YAML::Node yaml = YAML::LoadFile((folder.path() / "map.yaml").string());
  EXPECT_EQ(yaml["frame"].as<std::string>(), "map");
  EXPECT_EQ(yaml["datum"]["latitude"].as<double>(), 48.1234567891);
  EXPECT_EQ(yaml["resolution"].as<double>(), 0.1);
  EXPECT_EQ(yaml["points"].as<int>(), 1000);
  EXPECT_NEAR(yaml["min"][1].as<double>(), -49.95, 1e-3);
  EXPECT_NEAR(yaml["max"][0].as<double>(), 99.9, 1e-3);
}

// Floats hold northings of UTM only to half a metre; distances in the file are right to a
// millimetre, and with the origin beside it each point has a position on Earth.
TEST(WritePointFiles, UtmFilesKeepDistancesAndOrigin) {
  const TemporaryFolder folder;
  MapDescription description;
  description.datum = GeodeticDatum{49.0, 8.4, 110.0};
  description.utm.emplace(*description.datum);
  const UtmFrame& utm = *description.utm;
  const PointCloud map = example_map();
  const CloudParts moved = stored_parts(
      map,
      [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return utm.from_enu(p) - utm.origin(); },
      folder.path());
  const Files files = write_point_files(moved, description, folder.path(), {"pcd"});
  EXPECT_EQ(files.size(), 3U);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((folder.path() / "map.pcd").string(), cloud), 0);
  std::ifstream origin_file(folder.path() / "map.pcd.utm");
  Eigen::Vector3d origin;
  origin_file >> origin.x() >> origin.y() >> origin.z();
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Eigen::Vector3d p_utm = cloud[i].getVector3fMap().cast<double>() + origin;
    const Eigen::Vector3d p_enu = map.points[i].position().cast<double>();
    ASSERT_TRUE(test::near(utm.to_enu(p_utm), p_enu, 0.001));
    if (i == 0) continue;
    const auto step = (cloud[i].getVector3fMap() - cloud[i - 1].getVector3fMap()).norm();
    const auto expected = (map.points[i].position() - map.points[i - 1].position()).norm();
    ASSERT_NEAR(static_cast<double>(step), static_cast<double>(expected), 0.001);
  }
  EXPECT_GT(std::abs(cloud[999].y - map.points[999].y), 0.5F) << "grid north is not north";
  const YAML::Node yaml = YAML::LoadFile((folder.path() / "map.yaml").string());
  EXPECT_EQ(yaml["epsg"].as<int>(), 32632);
  EXPECT_NEAR(yaml["utm_origin"][0].as<double>(), origin.x(), 1e-6);
  EXPECT_EQ(yaml["frame"].as<std::string>(), "utm");
  description.utm.reset();
  write_point_files(map, description, folder.path(), {"pcd"});
  EXPECT_FALSE(fs::exists(folder.path() / "map.pcd.utm")) << "it would be wrong now";
}

TEST(WritePointFiles, RunsConcurrentTaskOnceFilesCanBeWritten) {
  const TemporaryFolder folder;
  for (const int threads : {1, 2}) {
    int done = 0;
    const ConcurrentTask concurrent_task = {[&done] { ++done; }, threads};
    EXPECT_THROW(write_point_files(PointCloud(), {}, folder.path(), {}, concurrent_task),
                 InputError);
    EXPECT_EQ(done, 0);
    write_point_files(example_map(), {}, folder.path(), {}, concurrent_task);
    EXPECT_EQ(done, 1);
  }
}

// Impossible requests are reported.
TEST(WritePointFiles, RejectsUnknownFormatsEmptyMapsAndUnwritableFolders) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_point_files(example_map(), {}, folder.path(), {"doc"}), InputError);
  EXPECT_THROW(write_point_files(PointCloud(), {}, folder.path(), {}), InputError);
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_THROW(write_point_files(example_map(), {}, folder.path() / "file", {}), FileError);
}

// Files of other origin are not overwritten; those of this package are.
TEST(WritePointFiles, ReplacesItsOwnFilesOnly) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "map.pcd") << "mine";
  EXPECT_THROW(write_point_files(example_map(), {}, folder.path(), {}), FileError);
  EXPECT_EQ(fs::file_size(folder.path() / "map.pcd"), 4U);
  const fs::path own = folder.path() / "own";
  write_point_files(example_map(), {}, own, {});
  EXPECT_NO_THROW(write_point_files(example_map(), {}, own, {}));
  // The description of what is written would stand beside it.
  EXPECT_THROW(write_point_files(example_map(), {}, folder.path(), {"ply"}), FileError);
  EXPECT_FALSE(fs::exists(folder.path() / "map.yaml"));
}

TEST(WritePointFiles, LeavesNoFileThatItsDescriptionDoesNotDescribe) {
  const TemporaryFolder folder;
  MapDescription in_utm;
  in_utm.datum = GeodeticDatum{49.0, 8.4, 110.0};
  in_utm.utm.emplace(*in_utm.datum);
  write_point_files(example_map(), in_utm, folder.path(), {"pcd", "ply"});
  write_point_files(example_map(), in_utm, folder.path(), {"pcd"});
  EXPECT_TRUE(fs::exists(folder.path() / "map.ply")) << "it is still described";
  MapDescription in_map = in_utm;
  in_map.utm.reset();
  write_point_files(example_map(), in_map, folder.path(), {"pcd"});
  EXPECT_TRUE(fs::exists(folder.path() / "map.pcd"));
  for (const char* name : {"map.ply", "map.ply.utm", "map.pcd.utm"}) {
    EXPECT_FALSE(fs::exists(folder.path() / name)) << name;
  }
}

TEST(TopView, DrawsPointsAtTheirPositions) {
  PointCloud map;
  map.points = {{0.0F, 0.0F, 0.0F, 0.0F}, {9.0F, 0.0F, 0.0F, 0.0F}, {9.0F, 4.0F, 9.0F, 0.0F}};
  const TopView view = top_view(map, 1.0);
  EXPECT_EQ(view.width, 10);
  EXPECT_EQ(view.height, 5);
  const auto brightness = [&](int column, int row) {
    const std::size_t at = 3U * static_cast<std::size_t>(row * view.width + column);
    return view.rgb[at] + view.rgb[at + 1] + view.rgb[at + 2];
  };
  EXPECT_GT(brightness(0, 4), 100);
  EXPECT_GT(brightness(9, 0), 100);
  EXPECT_LT(brightness(5, 2), 60);
  EXPECT_NE(view.rgb[3 * 9], view.rgb[3 * (4 * 10 + 9)]) << "height shows as colour";
}

TEST(TopView, PointBelowGroundChangesNoOtherPixel) {
  PointCloud map;
  for (int i = 0; i < 64; ++i) {
    map.points.push_back(
        {0.5F + static_cast<float>(i % 8), 0.5F + static_cast<float>(i / 8), 0.0F, 0.0F});
  }
  const TopView clean = top_view(map, 1.0);
  map.points.push_back({4.5F, 4.5F, -6.0F, 0.0F});
  const TopView mirrored = top_view(map, 1.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(mirrored.rgb[i], clean.rgb[i]);
}

// Nine of 113,273 points of a recorded hall made its picture ten times as wide as the hall.
TEST(TopView, AFewStrayPointsFarOutsideDoNotMakeTheRestSmall) {
  PointCloud map;
  for (int i = 0; i < 100'000; ++i) {
    map.points.push_back(
        {0.1F * static_cast<float>(i % 400), 0.1F * static_cast<float>(i / 400), 0.0F, 0.0F});
  }
  const TopView clean = top_view(map, 0.5);
  EXPECT_NEAR(clean.width * clean.pixel_m, 40.0, 1.0);
  for (int i = 0; i < 9; ++i) {
    map.points.push_back({400.0F + static_cast<float>(i), 5.0F, 1.0F, 0.0F});
  }
  const TopView view = top_view(map, 0.5);
  EXPECT_EQ(view.height, clean.height);
  EXPECT_LT(view.width, 1.15 * clean.width);
  for (int i = 0; i < 9; ++i) {
    map.points.push_back({43.0F, 2.0F * static_cast<float>(i), 1.0F, 0.0F});
  }
  EXPECT_NEAR(top_view(map, 0.5).width, view.width, 1) << "what is close stays in the picture";
}

TEST(TopView, LimitsPictureSize) {
  PointCloud map;
  map.points = {{0.0F, 0.0F, 0.0F, 0.0F}, {10'000.0F, 5.0F, 0.0F, 0.0F}};
  const TopView view = top_view(map, 0.1, 500);
  EXPECT_LE(view.width, 500);
  EXPECT_GT(view.pixel_m, 10.0);
  EXPECT_THROW(top_view(PointCloud(), 1.0), InputError);
}

TEST(TopView, WritesPictureAndWorldFile) {
  const TemporaryFolder folder;
  write_png(folder.path() / "top_view.png", top_view(example_map(), 0.5));
  std::ifstream png(folder.path() / "top_view.png", std::ios::binary);
  std::string magic(8, '\0');
  png.read(magic.data(), 8);
  EXPECT_EQ(magic.substr(1, 3), "PNG");
  std::ifstream world(folder.path() / "top_view.pgw");
  double numbers[6];
  for (double& number : numbers) world >> number;
  EXPECT_EQ(numbers[0], 0.5);
  EXPECT_EQ(numbers[3], -0.5);
  EXPECT_NEAR(numbers[4], 0.25, 1e-6);
  EXPECT_NEAR(numbers[5], -0.25, 1e-6);
}

}  // namespace
}  // namespace lidar_mapping::map
