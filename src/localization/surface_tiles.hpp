// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

namespace lidar_mapping::localization {

/// The Gaussians of a whole map, of which a table of bounded size holds those that are needed now.
/// They are kept by tiles, squares as seen from above. The table grows until it has reached its
/// bound. From then on, tiles that were not required for the longest time are dropped where others
/// need their room: they wait in a file without a name. What comes back is the same bit for bit, so
/// no result depends on the bound. Throws FileError; all Gaussians are then still there. One thread
/// at a time uses it.
class SurfaceTiles {
 public:
  /// How the table is made.
  struct Options {
    double voxel_edge = 1.0;         ///< m
    registration::PlaneModel model;  ///< of the planes of the voxels
    int tile_edge = 48;              ///< voxels
    std::size_t first_slots = 1024;  ///< of the table at first
    /// The bound: tiles are dropped where the table would get more slots. Only tiles that are
    /// required together, and do not fit, make it larger.
    std::size_t most_slots = std::numeric_limits<std::size_t>::max();
  };

  /// The file is created in `directory` when the first tile is dropped.
  SurfaceTiles(const Options& options, std::filesystem::path directory);

  /// The Gaussians that are in the table: at least those of the tiles that were required last.
  registration::GaussianVoxelMap& voxels() { return voxels_; }
  /// The Gaussians that are in the table.
  const registration::GaussianVoxelMap& voxels() const { return voxels_; }
  /// Number of Gaussians of the whole map.
  std::size_t size() const { return voxels_.size() + away_; }
  /// True if all of them are in the table.
  bool is_whole() const { return away_ == 0; }
  /// Memory of the table, bytes.
  std::size_t bytes() const {
    return voxels_.table().slots().size() * sizeof(registration::VoxelSums);
  }

  /// Has all Gaussians within `radius` (m, along x and y) of a position of the map in the table.
  /// Takes next to no time if the whole map is there, or if the tiles are those required last.
  void require(const Eigen::Vector3d& p_map, double radius);
  /// Adds points as GaussianVoxelMap::insert() does; they must lie within `radius` (m, along x and
  /// y) of a position of the map. None is lost: the table grows where they do not fit.
  void insert(const Eigen::Vector3d& p_map, double radius, const float* x, const float* y,
              const float* z, std::size_t count,
              const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt);

 private:
  /// Column and row of a tile in one word.
  using TileKey = std::uint64_t;
  /// A rectangle of tiles: columns count along x, rows along y, and both ends belong to it.
  struct Range {
    int first_column = 0;
    int last_column = -1;
    int first_row = 0;
    int last_row = -1;
    bool operator==(const Range& other) const;
  };
  struct Tile {
    bool is_away = false;             ///< waits in the file, and is not in the table
    bool is_changed = false;          ///< since it was written
    std::uint64_t last_required = 0;  ///< number of the request
    std::size_t voxels = 0;           ///< when it was dropped
    std::uint64_t offset = 0;         ///< in the file, bytes
    std::size_t room = 0;             ///< there, voxels
  };
  using SlotsOfTiles = std::unordered_map<TileKey, std::vector<std::uint32_t>>;

  Range range_around(const Eigen::Vector3d& p_map, double radius) const;
  TileKey tile_of(VoxelKey key) const;
  void request(const Range& range);
  void put_back(Tile& tile);
  void make_room(std::size_t voxels);
  void drop_oldest(std::size_t voxels);
  SlotsOfTiles slots_of_tiles() const;
  std::vector<TileKey> oldest_first() const;
  void write(const std::vector<std::uint32_t>& slots, Tile& tile);

  Options options_;
  std::filesystem::path directory_;
  registration::GaussianVoxelMap voxels_;
  std::unordered_map<TileKey, Tile> tiles_;
  std::size_t away_ = 0;        ///< voxels that wait in the file
  Range newest_;                ///< that was requested last, if all of it is there
  std::uint64_t requests_ = 0;  ///< number so far
  std::unique_ptr<NamelessFile> file_;
  std::uint64_t file_end_ = 0;                   ///< bytes
  std::vector<registration::VoxelSums> buffer_;  ///< scratch: a tile
};

}  // namespace lidar_mapping::localization
