// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/point_field_names.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

#include "error_text.hpp"
#include "map_input.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map_import {
namespace {

namespace fs = std::filesystem;
using test::error_text;
using test::near;
using test::TemporaryFolder;

void write_text(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   std::size_t points, const std::string& data) {
  const std::string count = std::to_string(points);
  return "VERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types + "\nWIDTH " +
         count + "\nHEIGHT 1\nPOINTS " + count + "\nDATA " + data + "\n";
}

template <typename Number>
void append(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::vector<MapPoint> all_points(const fs::path& file) {
  std::vector<MapPoint> all;
  read_points(file, [&](const std::vector<MapPoint>& points) {
    all.insert(all.end(), points.begin(), points.end());
  });
  return all;
}

PointCloud three_points() {
  PointCloud cloud;
  cloud.points = {{1.0F, 2.0F, 3.0F, 4.0F}, {-5.5F, 6.25F, 7.0F, 8.0F}, {0.0F, 0.5F, 0.0F, 9.0F}};
  return cloud;
}

void expect_three_points(const std::vector<MapPoint>& points) {
  const PointCloud expected = three_points();
  ASSERT_EQ(points.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(near(points[i].p_map, expected.points[i].position().cast<double>(), 1e-12));
    EXPECT_EQ(points[i].intensity, expected.points[i].intensity);
  }
}

TEST(MapPoints, OfAllEncodingsAreRead) {
  const TemporaryFolder folder;
  const PointCloud cloud = three_points();
  session::write_pcd(folder.path() / "binary.pcd", cloud);
  map::write_pcd(folder.path() / "compressed.pcd", cloud);
  write_text(folder.path() / "ascii.pcd",
             header("x y z intensity", "4 4 4 4", "F F F F", 3, "ascii") +
                 "1 2 3 4\n-5.5 6.25 7 8\n0 0.5 0 9\n");
  for (const char* name : {"binary.pcd", "compressed.pcd", "ascii.pcd"}) {
    SCOPED_TRACE(name);
    expect_three_points(all_points(folder.path() / name));
  }
}

TEST(MapPoints, AreReadInParts) {
  const TemporaryFolder folder;
  PointCloud cloud;
  for (int i = 0; i < 250'000; ++i)
    cloud.points.push_back({1.0F, 2.0F, 3.0F, static_cast<float>(i)});
  session::write_pcd(folder.path() / "map.pcd", cloud);
  std::size_t parts = 0;
  float next = 0.0F;
  read_points(folder.path() / "map.pcd", [&](const std::vector<MapPoint>& points) {
    ++parts;
    for (const MapPoint& point : points) ASSERT_EQ(point.intensity, next++);
  });
  EXPECT_EQ(next, 250'000.0F);
  EXPECT_GT(parts, 1U);
}

TEST(MapPoints, OfOtherLayoutsAreRead) {
  const TemporaryFolder folder;
  const Eigen::Vector3d utm(456789.1234, 5428765.4321, 123.4567);
  std::string bytes;
  append(bytes, std::uint8_t{7});
  for (const double number : {utm.x(), utm.y(), utm.z()}) append(bytes, number);
  append(bytes, std::uint16_t{300});
  std::vector<std::string> names(kIntensityNames.begin(), kIntensityNames.end());
  names.emplace_back("Intensity");
  for (const std::string& name : names) {
    write_text(folder.path() / "utm.pcd",
               header("label x y z " + name, "1 8 8 8 2", "U F F F U", 1, "binary") + bytes);
    const std::vector<MapPoint> points = all_points(folder.path() / "utm.pcd");
    ASSERT_EQ(points.size(), 1U);
    EXPECT_TRUE(near(points[0].p_map, utm, 1e-9));
    EXPECT_EQ(points[0].intensity, 300.0F) << name;
  }
}

TEST(MapPoints, ThatAreNoNumbersAreLeftOut) {
  const TemporaryFolder folder;
  PointCloud cloud = three_points();
  cloud.points[1].x = std::numeric_limits<float>::quiet_NaN();
  cloud.points.push_back({1e30F, 0.0F, 0.0F, 1.0F});
  session::write_pcd(folder.path() / "map.pcd", cloud);
  EXPECT_EQ(all_points(folder.path() / "map.pcd").size(), 2U);
}

TEST(MapPoints, ThatFloatsCannotHoldAreRefused) {
  const TemporaryFolder folder;
  PointCloud cloud;
  cloud.points = {{456789.0F, 5428765.0F, 100.0F, 0.0F}};
  session::write_pcd(folder.path() / "utm.pcd", cloud);
  const std::string said = error_text<InputError>([&] { all_points(folder.path() / "utm.pcd"); });
  EXPECT_NE(said.find("utm.pcd"), std::string::npos) << said;
  EXPECT_NE(said.find("5428765 m as floats of 4 bytes"), std::string::npos) << said;
}

TEST(MapPoints, NeedCoordinates) {
  const TemporaryFolder folder;
  write_text(folder.path() / "map.pcd", header("x y i", "4 4 4", "F F F", 1, "ascii") + "1 2 3\n");
  EXPECT_NE(error_text<FileError>([&] {
              all_points(folder.path() / "map.pcd");
            }).find("no fields x y z of floats"),
            std::string::npos);
}

TEST(MapFiles, AreThoseThatTheListOfTilesNames) {
  const TemporaryFolder folder;
  const fs::path map = folder.path() / "map";
  for (const char* name : {"0_0.pcd", "0_20.pcd", "other.pcd"}) write_text(map / name, "");
  const std::string list =
      "x_resolution: 20.0\ny_resolution: 20.0\n0_20.pcd: [0, 20]\n0_0.pcd: [0, 0]\n";
  write_text(map / "pointcloud_map_metadata.yaml", list);
  EXPECT_EQ(map_files(map), (std::vector<fs::path>{map / "0_0.pcd", map / "0_20.pcd"}));
  write_text(map / "pointcloud_map_metadata.yaml", list + "missing.pcd: [40, 0]\n");
  EXPECT_NE(error_text<FileError>([&] { map_files(map); }).find("the tile missing.pcd"),
            std::string::npos);
}

TEST(MapFiles, MayLieBesideTheListInAFolderOfTheirOwn) {
  const TemporaryFolder folder;
  write_text(folder.path() / "pointcloud_map_metadata.yaml", "x_resolution: 20\na.pcd: [0, 0]\n");
  const fs::path tile = folder.path() / "pointcloud_map.pcd" / "a.pcd";
  write_text(tile, "");
  EXPECT_EQ(map_files(folder.path()), std::vector<fs::path>{tile});
}

TEST(MapFiles, AreAllOfAFolderWithoutAList) {
  const TemporaryFolder folder;
  const fs::path& map = folder.path();
  for (const char* name : {"b.PCD", "a.pcd", "readme.txt"}) write_text(map / name, "");
  EXPECT_EQ(map_files(map), (std::vector<fs::path>{map / "a.pcd", map / "b.PCD"}));
  EXPECT_EQ(map_files(map / "a.pcd"), std::vector<fs::path>{map / "a.pcd"});
}

TEST(MapFiles, OfWhatIsNoMapAreRefused) {
  const TemporaryFolder folder;
  const auto said = [&](const fs::path& map) {
    return error_text<FileError>([&] { map_files(map); });
  };
  EXPECT_NE(said(folder.path()).find("nor a PCD file in"), std::string::npos);
  EXPECT_NE(said(folder.path() / "gone").find("there is no map"), std::string::npos);
  write_text(folder.path() / "town.laz", "");
  EXPECT_NE(said(folder.path() / "town.laz").find("is a LAS file"), std::string::npos);
  const fs::path list = folder.path() / "pointcloud_map_metadata.yaml";
  write_text(list, "x_resolution: 20\n");
  EXPECT_NE(said(folder.path()).find("names no PCD file"), std::string::npos);
}

TEST(DatumBeside, IsReadFromTheDescriptionOfAMap) {
  const TemporaryFolder folder;
  const fs::path map = folder.path() / "town.pcd";
  EXPECT_FALSE(datum_beside(map));
  const std::string datum = "datum: {latitude: 49.5, longitude: 8, altitude: 110.25}\n";
  write_text(folder.path() / "town.yaml", "frame: map\n" + datum);
  EXPECT_EQ(datum_beside(map), (GeodeticDatum{49.5, 8.0, 110.25}));
  write_text(folder.path() / "town.yaml", "frame: utm\n" + datum);
  EXPECT_FALSE(datum_beside(map)) << "its axes are those of the grid";
  write_text(folder.path() / "town.yaml", "datum: {latitude: 95.0, longitude: 8, altitude: 110}\n");
  EXPECT_FALSE(datum_beside(map)) << "there is no such place";
  write_text(folder.path() / "town.yaml", "frame: map\ndatum: null\n");
  EXPECT_FALSE(datum_beside(map));
  write_text(folder.path() / "town.yaml", "[no map\n");
  EXPECT_FALSE(datum_beside(map)) << "a file of somebody else";
}

TEST(DatumBeside, IsReadFromAutowaresProjector) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "map_projector_info.yaml";
  const std::string origin =
      "map_origin:\n  latitude: 35.5\n  longitude: 139.5\n  altitude: 40.0\n";
  write_text(file, "projector_type: LocalCartesian\nvertical_datum: WGS84\n" + origin);
  fs::create_directory(folder.path() / "pointcloud_map.pcd");
  const GeodeticDatum expected{35.5, 139.5, 40.0};
  EXPECT_EQ(datum_beside(folder.path()), expected);
  EXPECT_EQ(datum_beside(folder.path() / "pointcloud_map.pcd"), expected);
  EXPECT_EQ(datum_beside(folder.path() / "town.pcd"), expected);
  write_text(file, "projector_type: MGRS\nvertical_datum: WGS84\n" + origin);
  EXPECT_FALSE(datum_beside(folder.path()));
  write_text(file, "projector_type: LocalCartesian\nvertical_datum: EGM2008\n" + origin);
  EXPECT_FALSE(datum_beside(folder.path()));
}

}  // namespace
}  // namespace lidar_mapping::map_import
