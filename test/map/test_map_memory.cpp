// SPDX-License-Identifier: BSD-3-Clause
// A program of its own, as it counts what every allocation takes.

#include <atomic>
#include <cstdlib>
#include <new>
#include <random>

#include <gtest/gtest.h>
#include <malloc.h>

#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/map_files.hpp"

#include "temporary_folder.hpp"

namespace {

std::atomic<std::size_t> held{0};
std::atomic<std::size_t> most_held{0};

void count(void* memory) {
  const std::size_t now = held += malloc_usable_size(memory);
  std::size_t most = most_held;
  while (now > most && !most_held.compare_exchange_weak(most, now)) {
  }
}

}  // namespace

// Not inlined, or compilers take them for a mismatch of new and free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  count(memory);
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  if (memory != nullptr) held -= malloc_usable_size(memory);
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  operator delete(memory);
}

namespace lidar_mapping::map {
namespace {

constexpr double kStep = 5.0;  // m between key frames
constexpr double kTownSize = 1000.0;

/// Makes each cloud when it is asked for, so that only the map takes memory.
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

/// Up and down parallel streets.
KeyFramePoses drive(double length) {
  KeyFramePoses poses;
  for (KeyFrameIndex index = 0; kStep * index < length; ++index) {
    Pose pose;
    const double way = kStep * index;
    pose.translation = {std::fmod(way, kTownSize), 50.0 * std::floor(way / kTownSize), 0.0};
    poses.poses.push_back({index, Stamp{index}, pose});
  }
  return poses;
}

using Use = std::function<void(const TileSource& tiles)>;

/// Bytes held at the worst moment while something is made of the tiles of a drive.
std::size_t peak_of(double length, const Use& use) {
  Street street;
  const KeyFramePoses poses = drive(length);
  MapConfig config;
  config.threads = 2;
  most_held = held.load();
  const std::size_t before = held;
  std::size_t points = 0;
  const test::TemporaryFolder folder;
  use([&](const TileSink& sink) {
    build_tiles(poses, street, config, folder.path(), [&](const MapTile& tile) {
      points += tile.cloud.size();
      sink(tile);
    });
  });
  EXPECT_GT(points, 50U * poses.poses.size());
  return most_held - before;
}

void expect_no_more_for_a_longer_drive(const Use& use) {
  peak_of(1000.0, use);  // what is allocated once
  const double shorter = static_cast<double>(peak_of(5000.0, use));
  const double longer = static_cast<double>(peak_of(20000.0, use));
  EXPECT_LT((longer - shorter) / (15000.0 / kStep), 600.0) << "bytes for each further key frame";
  EXPECT_LT(longer, 1.25 * shorter);
}

// The memory of a map that is built by tiles is that of the tiles around the vehicle.
TEST(BuildTiles, NeedsNoMoreMemoryForAFourTimesLongerDrive) {
  expect_no_more_for_a_longer_drive([](const TileSource& tiles) { tiles([](const MapTile&) {}); });
}

TEST(SaveMap, NeedsNoMoreMemoryForAFourTimesLongerDrive) {
  const test::TemporaryFolder folder;
  expect_no_more_for_a_longer_drive([&](const TileSource& tiles) {
    save_map(stored_parts(tiles, folder.path()), {}, folder.path(), {"ply"});
  });
}

}  // namespace
}  // namespace lidar_mapping::map
