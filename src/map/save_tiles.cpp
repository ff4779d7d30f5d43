// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

std::string tile_file_name(const Eigen::Vector3d& origin) {
  return formatted("%lld_%lld.pcd", static_cast<long long>(std::llround(origin.x())),
                   static_cast<long long>(std::llround(origin.y())));
}

constexpr const char* kMetadata = "pointcloud_map_metadata.yaml";

/// Replaces an older folder by a finished one.
void replace_folder(const fs::path& finished, const fs::path& directory) {
  const fs::path old = directory.parent_path() / ("." + directory.filename().string() + ".old");
  fs::remove_all(old);
  if (fs::exists(directory)) fs::rename(directory, old);
  fs::rename(finished, directory);
  fs::remove_all(old);
}

Files write_tiles(const TileSource& tiles, double tile_size, const fs::path& directory) {
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

Files save_tiles(const TileSource& tiles, double tile_size, const fs::path& directory) {
  if (fs::exists(directory) && !fs::exists(directory / kMetadata)) {
    throw FileError(directory.string() +
                    " is there already and holds no tiles of a map; name another directory");
  }
  const fs::path target = fs::absolute(directory / ".").lexically_normal().parent_path();
  const fs::path temporary = target.parent_path() / ("." + target.filename().string() + ".part");
  Files files;
  try {
    fs::remove_all(temporary);
    for (const fs::path& name : write_tiles(tiles, tile_size, temporary)) {
      files.push_back(directory / name);
    }
    replace_folder(temporary, target);
  } catch (const fs::filesystem_error& error) {
    throw FileError("cannot write " + directory.string() + ": " + error.what());
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  return files;
}

}  // namespace lidar_mapping::map
