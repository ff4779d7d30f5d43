// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/text.hpp"

#include "files/whole_folder.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

std::string tile_file_name(const Eigen::Vector3d& origin) {
  return formatted("%lld_%lld.pcd", static_cast<long long>(std::llround(origin.x())),
                   static_cast<long long>(std::llround(origin.y())));
}

constexpr const char* kMetadata = "pointcloud_map_metadata.yaml";

Files write_tile_files(const TileSource& tiles, double tile_size, const fs::path& directory) {
  Files names;
  std::string metadata =
      formatted("x_resolution: %.9g\ny_resolution: %.9g\n", tile_size, tile_size);
  tiles([&](const MapTile& tile) {
    if (tile.cloud.empty()) return;
    names.emplace_back(tile_file_name(tile.origin));
    write_pcd(directory / names.back(), in_map_frame(tile));
    metadata +=
        formatted("%s: [%.9g, %.9g]\n", names.back().c_str(), tile.origin.x(), tile.origin.y());
  });
  names.emplace_back(kMetadata);
  write_text_atomically(directory / kMetadata, metadata);
  return names;
}

}  // namespace

Files write_tiles(const TileSource& tiles, double tile_size, const fs::path& directory) {
  Files files;
  write_whole_folder(directory, kMetadata, "tiles of a map", [&](const fs::path& folder) {
    for (const fs::path& name : write_tile_files(tiles, tile_size, folder)) {
      files.push_back(directory / name);
    }
  });
  return files;
}

}  // namespace lidar_mapping::map
