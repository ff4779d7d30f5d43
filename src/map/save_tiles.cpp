#include <cmath>
#include <cstdio>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_products.hpp"

namespace lidar_mapping::map {

namespace {

std::string name_of(const Eigen::Vector3d& origin) {
  char name[64];
  std::snprintf(name, sizeof name, "%lld_%lld.pcd",
                static_cast<long long>(std::llround(origin.x())),
                static_cast<long long>(std::llround(origin.y())));
  return name;
}

PointCloud in_map_frame(const MapTile& tile) {
  PointCloud cloud = tile.cloud;
  for (Point& point : cloud.points) {
    point.x = static_cast<float>(static_cast<double>(point.x) + tile.origin.x());
    point.y = static_cast<float>(static_cast<double>(point.y) + tile.origin.y());
  }
  return cloud;
}

}  // namespace

Files save_tiles(const TileSource& tiles, double tile_size,
                 const std::filesystem::path& directory) {
  if (std::filesystem::exists(directory)) {
    throw FileError(directory.string() + " is there already; name another directory");
  }
  Files files;
  char line[160];
  std::snprintf(line, sizeof line, "x_resolution: %.9g\ny_resolution: %.9g\n", tile_size,
                tile_size);
  std::string metadata = line;
  tiles([&](const MapTile& tile) {
    if (tile.cloud.empty()) return;
    const std::string name = name_of(tile.origin);
    write_pcd(directory / name, in_map_frame(tile));
    files.push_back(directory / name);
    std::snprintf(line, sizeof line, "%s: [%.9g, %.9g]\n", name.c_str(), tile.origin.x(),
                  tile.origin.y());
    metadata += line;
  });
  files.push_back(directory / "pointcloud_map_metadata.yaml");
  write_text_atomically(files.back(), metadata);
  return files;
}

}  // namespace lidar_mapping::map
