// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

#include "error_text.hpp"
#include "example_values.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::session {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

constexpr std::size_t kBytesOfExample = 100 * sizeof(Point);

TEST(CloudStore, ReadsTheCloudsThatItWrote) {
  const TemporaryFolder folder;
  CloudStore(folder.path() / "clouds").put(7, example_cloud(100, 7));
  CloudStore store(folder.path() / "clouds");
  ASSERT_NE(store.cloud(7), nullptr);
  expect_equal(*store.cloud(7), *example_cloud(100, 7));
  EXPECT_EQ(store.file(7).filename(), "000007.pcd");
}

TEST(CloudStore, LinksFilesOfOthersAndReplacesItsOwn) {
  const TemporaryFolder folder;
  CloudStore other(folder.path() / "other");
  other.put(7, example_cloud(100, 7));
  CloudStore store(folder.path() / "clouds");
  store.link(2, other.file(7));
  store.link(2, other.file(7));
  ASSERT_NE(store.cloud(2), nullptr);
  expect_equal(*store.cloud(2), *example_cloud(100, 7));
  EXPECT_TRUE(fs::equivalent(store.file(2), other.file(7)));
  EXPECT_THROW(store.link(3, other.file(8)), FileError);
  EXPECT_FALSE(store.contains(3));
}

TEST(CloudStore, StoresEmptyClouds) {
  const TemporaryFolder folder;
  CloudStore(folder.path()).put(0, example_cloud(0, 0));
  CloudStore store(folder.path());
  ASSERT_NE(store.cloud(0), nullptr);
  EXPECT_TRUE(store.cloud(0)->empty());
}

TEST(CloudStore, CacheStaysWithinItsLimit) {
  const TemporaryFolder folder;
  CloudStore store(folder.path(), 3 * kBytesOfExample);
  for (KeyFrameIndex index = 0; index < 20; ++index) {
    store.put(index, example_cloud(100, static_cast<int>(index)));
    EXPECT_LE(store.cached_bytes(), 3 * kBytesOfExample);
  }
  for (KeyFrameIndex index = 0; index < 20; ++index) {
    expect_equal(*store.cloud(index), *example_cloud(100, static_cast<int>(index)));
    EXPECT_LE(store.cached_bytes(), 3 * kBytesOfExample);
  }
}

TEST(CloudStore, CacheShrinksWithItsLimit) {
  const TemporaryFolder folder;
  CloudStore store(folder.path(), 3 * kBytesOfExample);
  for (KeyFrameIndex index = 0; index < 3; ++index) store.put(index, example_cloud(100, 1));
  const PointCloudPtr newest = store.cloud(2);
  store.set_cache_bytes(kBytesOfExample);
  EXPECT_EQ(store.cached_bytes(), kBytesOfExample);
  EXPECT_TRUE(store.is_cached(2, newest));
  EXPECT_NE(store.cloud(0), nullptr);
}

TEST(CloudStore, RemovesTheLeastRecentlyUsedCloud) {
  const TemporaryFolder folder;
  CloudStore store(folder.path(), 2 * kBytesOfExample);
  store.put(0, example_cloud(100, 0));
  store.put(1, example_cloud(100, 1));
  const PointCloudPtr zero = store.cloud(0);
  store.put(2, example_cloud(100, 2));
  EXPECT_EQ(store.cloud(0), zero) << "still the same object: it was used last";
}

TEST(CloudStore, ReadsSeveralInOrderWithAnyNumberOfThreads) {
  const TemporaryFolder folder;
  CloudStore(folder.path()).put(4, example_cloud(40, 4));
  CloudStore(folder.path()).put(7, example_cloud(70, 7));
  for (const int threads : {1, 3}) {
    CloudStore store(folder.path());
    const std::vector<PointCloudPtr> clouds = store.clouds({7, 5, 4, 7}, threads);
    ASSERT_EQ(clouds.size(), 4U);
    EXPECT_EQ(clouds[0]->size(), 70U);
    EXPECT_EQ(clouds[1], nullptr);
    EXPECT_EQ(clouds[2]->size(), 40U);
    EXPECT_EQ(clouds[3]->size(), 70U);
  }
}

// A missing or truncated file gives no cloud. It never gives an empty cloud and never crashes.
TEST(CloudStore, GivesNoCloudForMissingOrDamagedFiles) {
  const TemporaryFolder folder;
  CloudStore(folder.path()).put(3, example_cloud(100, 3));
  CloudStore store(folder.path());
  EXPECT_EQ(store.cloud(2), nullptr);
  const auto size = fs::file_size(store.file(3));
  for (const auto cut : {size - 1, size / 2, std::uintmax_t{40}, std::uintmax_t{0}}) {
    fs::resize_file(store.file(3), cut);
    EXPECT_EQ(store.cloud(3), nullptr) << "cut to " << cut << " bytes";
  }
}

// A temporary file of an interrupted writer is not a cloud and does not disturb others.
TEST(CloudStore, IgnoresTemporaryFilesOfAnInterruptedWriter) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / ".000003.pcd.part") << "half of a file";
  CloudStore store(folder.path());
  EXPECT_FALSE(store.contains(3));
  store.put(3, example_cloud(100, 3));
  EXPECT_FALSE(fs::exists(folder.path() / ".000003.pcd.part"));
  EXPECT_EQ(store.cloud(3)->size(), 100U);
}

TEST(CloudStore, ThrowsWhereItCannotWrite) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  CloudStore store(folder.path() / "file");
  EXPECT_THROW(store.put(0, example_cloud(100, 0)), FileError);
  EXPECT_EQ(store.cloud(0), nullptr);
}

TEST(PcdFile, ReadsFilesWithoutIntensity) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "plain.pcd")
      << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n";
  const PointCloud cloud = read_pcd(folder.path() / "plain.pcd");
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.points[0].position(), Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(cloud.points[0].intensity, 0.0F);
}

TEST(PcdFile, ReadsOtherLayouts) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "turned.pcd")
      << "VERSION 0.7\nFIELDS intensity z y x\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
         "WIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n4 3 2 1\n";
  const PointCloud cloud = read_pcd(folder.path() / "turned.pcd");
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.points[0].position(), Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(cloud.points[0].intensity, 4.0F);
}

/// A complete file of two points, with `line` of its header replaced by `other`.
std::string pcd_with(const std::string& line, const std::string& other) {
  std::string text =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\n"
      "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n" +
      std::string(24, 'p');
  const std::size_t at = text.find(line);
  return text.replace(at, line.size(), other);
}

// PCL's reader would take these points for a line of the header that changes the fields, and would
// read beyond the end.
TEST(PcdFile, DoesNotReadPointsAsLinesOfTheHeader) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "a.pcd";
  std::ofstream(path, std::ios::binary)
      << "VERSION 0.7\nFIELDS x y z _ intensity\nSIZE 4 4 4 1 4\nTYPE F F F U F\nWIDTH 1\n"
         "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\nCOUNT 1 1 19 1\n" +
             std::string("AB", 2);
  const PointCloud cloud = read_pcd(path);
  ASSERT_EQ(cloud.size(), 1U);
  float intensity = 0.0F;
  std::memcpy(&intensity, "1\nAB", sizeof intensity);
  EXPECT_EQ(cloud.points[0].intensity, intensity);
}

// PCL's reader writes outside of its memory for most of these.
TEST(PcdFile, RefusesDamagedHeadersAndNamesTheLine) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "a.pcd";
  const auto write = [&](const std::string& line, const std::string& other) {
    std::ofstream(path, std::ios::binary) << pcd_with(line, other);
  };
  write("", "");
  EXPECT_EQ(read_pcd(path).size(), 2U);
  const std::pair<const char*, const char*> damages[] = {
      {"POINTS 2\n", ""},
      {"VERSION 0.7\n", "\r\nVERSION 0.7\n"},  // PCL takes this for the end of the header
      {"HEIGHT 1\n", ""},
      {"WIDTH 2\n", ""},
      {"SIZE 4 4 4\n", ""},
      {"TYPE F F F\n", ""},
      {"FIELDS x y z\n", ""},
      {"FIELDS x y z", "FIELDS a y z"},
      {"FIELDS x y z", "FIELDS x y"},
      {"DATA binary\n", ""},
      {"DATA binary", "DATA"},
      {"DATA binary", "DATA binary_compressed"},
      {"POINTS 2", "POINTS 3"},
      {"POINTS 2", "POINTS -2"},
      {"WIDTH 2", "WIDTH 4294967297"},
      {"WIDTH 2\nHEIGHT 1", "WIDTH 65536\nHEIGHT 65536"},
      {"SIZE 4 4 4", "SIZE 4 4 400"},
      {"COUNT 1 1 1", "COUNT 1 1 0"},
      {"COUNT 1 1 1", "COUNT 1 1 2"},
      {"POINTS 2\n", "POINTS 2\nCOUNT 1 1 9\n"},
      {"VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0"},
      {"VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0 nan 1 0 0 0"},
      {"pppp", ""}};
  for (const auto& [line, other] : damages) {
    write(line, other);
    const std::string text = test::error_text<FileError>([&] { read_pcd(path); });
    EXPECT_NE(text.find("a.pcd"), std::string::npos) << line << " -> " << other << ": " << text;
  }
}

}  // namespace
}  // namespace lidar_mapping::session
