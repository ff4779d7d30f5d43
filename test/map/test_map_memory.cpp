// SPDX-License-Identifier: BSD-3-Clause
// A separate program, because it counts the memory of every allocation.

#include <atomic>
#include <cstdlib>
#include <new>
#include <random>

#include <gtest/gtest.h>
#include <malloc.h>

#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_files.hpp"

#include "files/ept_file.hpp"
#include "temporary_folder.hpp"

namespace {

std::atomic<std::size_t> bytes_in_use{0};
std::atomic<std::size_t> peak_bytes{0};

void count_allocation(void* memory) {
  const std::size_t now = bytes_in_use += malloc_usable_size(memory);
  std::size_t peak = peak_bytes;
  while (now > peak && !peak_bytes.compare_exchange_weak(peak, now)) {
  }
}

}  // namespace

// Not inlined, because compilers would report a mismatch of new and free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  count_allocation(memory);
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  if (memory != nullptr) bytes_in_use -= malloc_usable_size(memory);
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  operator delete(memory);
}

namespace lidar_mapping::map {
namespace {

constexpr double kStep = 5.0;  // m between key frames
constexpr double kTownSize = 1000.0;

/// Creates each cloud on demand, so that only the map needs memory.
class Street : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex index) override {
    std::mt19937 random(index);
    std::uniform_real_distribution<float> along(-30.0F, 30.0F);
    std::uniform_real_distribution<float> up(0.0F, 6.0F);
    auto cloud = std::make_shared<PointCloud>();
    for (int i = 0; i < 800; ++i) {
      cloud->points.push_back({along(random), i % 2 == 0 ? 8.0F : -8.0F, up(random), 0.0F});
    }
    return cloud;
  }
};

/// A drive up and down parallel streets.
KeyFramePoses drive(double length) {
  KeyFramePoses poses;
  for (KeyFrameIndex index = 0; kStep * index < length; ++index) {
    Pose pose;
    const double distance = kStep * index;
    pose.translation = {std::fmod(distance, kTownSize), 50.0 * std::floor(distance / kTownSize),
                        0.0};
    poses.poses.push_back({index, Stamp{index}, pose});
  }
  return poses;
}

using Use = std::function<void(const TileSource& tiles)>;

/// Largest number of bytes in use while `use` processes the tiles of a drive.
std::size_t peak_memory(double length, const Use& use) {
  Street street;
  const KeyFramePoses poses = drive(length);
  MapConfig config;
  config.threads = 2;
  peak_bytes = bytes_in_use.load();
  const std::size_t before = bytes_in_use;
  std::size_t points = 0;
  const test::TemporaryFolder folder;
  use([&](const TileSink& sink) {
    build_tiles(poses, street, config, folder.path(), [&](const MapTile& tile) {
      points += tile.cloud.size();
      sink(tile);
    });
  });
  EXPECT_GT(points, 50U * poses.poses.size());
  return peak_bytes - before;
}

void expect_no_growth_with_length(const Use& use) {
  peak_memory(1000.0, use);  // allocates what is allocated only once
  const double shorter = static_cast<double>(peak_memory(5000.0, use));
  const double longer = static_cast<double>(peak_memory(20000.0, use));
  EXPECT_LT((longer - shorter) / (15000.0 / kStep), 600.0) << "bytes for each further key frame";
  EXPECT_LT(longer, 1.25 * shorter);
}

// A map that is built tile by tile needs the memory of the tiles around the vehicle.
TEST(BuildTiles, MemoryDoesNotGrowWithLengthOfDrive) {
  expect_no_growth_with_length([](const TileSource& tiles) { tiles([](const MapTile&) {}); });
}

TEST(WritePointFiles, MemoryDoesNotGrowWithLengthOfDrive) {
  const test::TemporaryFolder folder;
  expect_no_growth_with_length([&](const TileSource& tiles) {
    write_point_files(stored_parts(tiles, folder.path()), {}, folder.path(), {"ply"});
  });
}

// A node that is divided on the disk has a buffer for each of its eight children. Four times the
// points have one level more of these, and an area that is twice as wide another one.
TEST(WriteEpt, MemoryGrowsWithTheLevelsAlone) {
  const test::TemporaryFolder folder;
  EptOptions options;
  options.origin = [](KeyFrameIndex) { return PointOrigin{}; };
  options.octree.points_in_memory = 50'000;
  options.octree.threads = 2;
  const Use use = [&](const TileSource& tiles) { write_ept(tiles, options, folder.path()); };
  peak_memory(1000.0, use);  // allocates what is allocated only once
  const double shorter = static_cast<double>(peak_memory(15000.0, use));
  const double longer = static_cast<double>(peak_memory(60000.0, use));
  EXPECT_LT(longer, 1.25 * shorter);
}

}  // namespace
}  // namespace lidar_mapping::map
