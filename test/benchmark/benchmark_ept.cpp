// SPDX-License-Identifier: BSD-3-Clause
// Time and memory of Entwine Point Tiles of a large map: a town that is repeated.
//   benchmark_ept FOLDER [MILLIONS OF POINTS]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "files/ept_file.hpp"

namespace lidar_mapping::map {
namespace {

constexpr double kTileSize = 50.0;  // m, that of maps by default

/// Ground, four walls and some trees, with a point every 0.2 m as in a map.
PointCloud block_of_town() {
  PointCloud cloud;
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 0.03F);
  const auto add = [&](float x, float y, float z) {
    cloud.points.push_back({x + noise(random), y + noise(random), z + noise(random), 1.0F + x});
  };
  for (int i = 0; i < 250; ++i) {
    const float u = 0.2F * static_cast<float>(i);
    for (int k = 0; k < 250; ++k) add(u, 0.2F * static_cast<float>(k), 0.0F);
    for (int k = 0; k < 50; ++k) {
      const float z = 0.2F * static_cast<float>(k);
      add(u, 10.0F, z);
      add(u, 40.0F, z);
      add(10.0F, u, z);
      add(40.0F, u, z);
    }
  }
  return cloud;
}

/// The blocks of a square town with at least so many points.
TileSource town(std::size_t points) {
  return [points](const TileSink& sink) {
    MapTile tile;
    tile.cloud = block_of_town();
    const auto blocks = static_cast<std::int64_t>(
        std::ceil(std::sqrt(static_cast<double>(points) / static_cast<double>(tile.cloud.size()))));
    for (tile.index.x = 0; tile.index.x < blocks; ++tile.index.x) {
      for (tile.index.y = 0; tile.index.y < blocks; ++tile.index.y) {
        tile.origin = {kTileSize * static_cast<double>(tile.index.x),
                       kTileSize * static_cast<double>(tile.index.y), 0.0};
        tile.key_frames.assign(tile.cloud.size(), static_cast<KeyFrameIndex>(tile.index.x));
        sink(tile);
      }
    }
  };
}

/// The line of the process's status that begins with this, by proc(5).
std::string status_line(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, name.size(), name) == 0) return line;
  }
  return {};
}

int run(const std::filesystem::path& folder, std::size_t points) {
  EptOptions options;
  options.datum = GeodeticDatum{49.0, 8.4, 120.0};
  options.origin = [](KeyFrameIndex index) { return PointOrigin{from_seconds(index), 0}; };
  const auto begin = std::chrono::steady_clock::now();
  write_ept(town(points), options, folder);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  std::printf("%.1f s, %s\n", seconds.count(), status_line("VmHWM").c_str());
  return 0;
}

}  // namespace
}  // namespace lidar_mapping::map

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: benchmark_ept FOLDER [MILLIONS OF POINTS]\n");
    return 2;
  }
  const double millions = argc > 2 ? std::stod(argv[2]) : 10.0;
  return lidar_mapping::map::run(argv[1], static_cast<std::size_t>(1e6 * millions));
}
