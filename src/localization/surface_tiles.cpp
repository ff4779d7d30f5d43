// SPDX-License-Identifier: BSD-3-Clause
#include "surface_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace lidar_mapping::localization {

namespace {

using registration::VoxelSums;
using registration::VoxelTable;

static_assert(std::is_trivially_copyable_v<VoxelSums>, "a file holds voxels as memory does");

/// Points that are inserted at a time, so that no table grows for many that share a voxel. Chosen.
constexpr std::size_t kChunk = 256;

/// Calls `act(key)` for each tile of a range.
template <typename Range, typename Act>
void for_each_tile(const Range& range, const Act& act) {
  for (int column = range.first_column; column <= range.last_column; ++column) {
    for (int row = range.first_row; row <= range.last_row; ++row) act(square_key(column, row));
  }
}

}  // namespace

bool SurfaceTiles::Range::operator==(const Range& other) const {
  return first_column == other.first_column && last_column == other.last_column &&
         first_row == other.first_row && last_row == other.last_row;
}

SurfaceTiles::SurfaceTiles(const Options& options, std::filesystem::path directory)
    : options_(options),
      directory_(std::move(directory)),
      voxels_(options.voxel_edge, std::min(options.first_slots, options.most_slots),
              options.model) {}

/// One voxel more to each side, because points are rounded to floats.
SurfaceTiles::Range SurfaceTiles::range_around(const Eigen::Vector3d& p_map, double radius) const {
  // The key comes back from the other side where those of voxels do.
  const VoxelIndex cell = voxel_index(voxel_key(voxel_index(p_map / options_.voxel_edge)));
  const int reach = static_cast<int>(std::ceil(radius / options_.voxel_edge)) + 1;
  const auto tile = [&](int voxel) { return floor_divided(voxel, options_.tile_edge); };
  Range range;
  range.first_column = tile(cell.x() - reach);
  range.last_column = tile(cell.x() + reach);
  range.first_row = tile(cell.y() - reach);
  range.last_row = tile(cell.y() + reach);
  return range;
}

SurfaceTiles::TileKey SurfaceTiles::tile_of(VoxelKey key) const {
  const VoxelIndex cell = voxel_index(key);
  return square_key(floor_divided(cell.x(), options_.tile_edge),
                    floor_divided(cell.y(), options_.tile_edge));
}

void SurfaceTiles::require(const Eigen::Vector3d& p_map, double radius) {
  if (is_whole()) return;
  const Range range = range_around(p_map, radius);
  if (!(range == newest_)) request(range);
}

void SurfaceTiles::insert(const Eigen::Vector3d& p_map, double radius, const float* x,
                          const float* y, const float* z, std::size_t count,
                          const std::optional<Eigen::Vector3f>& viewpoint) {
  const Range range = range_around(p_map, radius);
  for_each_tile(range, [&](TileKey key) { tiles_[key].is_changed = true; });
  request(range);
  for (std::size_t begin = 0; begin < count; begin += kChunk) {
    const std::size_t size = std::min(kChunk, count - begin);
    make_room(size);  // a point adds a voxel at most
    voxels_.insert(x + begin, y + begin, z + begin, size, viewpoint);
  }
}

/// Tiles of the newest request are not dropped.
void SurfaceTiles::request(const Range& range) {
  ++requests_;
  newest_ = {};
  std::vector<Tile*> missing;
  std::size_t voxels = 0;
  for_each_tile(range, [&](TileKey key) {
    const auto tile = tiles_.find(key);
    if (tile == tiles_.end()) return;
    tile->second.last_required = requests_;
    if (!tile->second.is_away) return;
    missing.push_back(&tile->second);
    voxels += tile->second.voxels;
  });
  make_room(voxels);
  for (Tile* const tile : missing) put_back(*tile);
  newest_ = range;
}

void SurfaceTiles::put_back(Tile& tile) {
  buffer_.resize(tile.voxels);
  file_->read(tile.offset, buffer_.data(), buffer_.size() * sizeof(VoxelSums));
  VoxelTable& table = voxels_.table();
  for (const VoxelSums& voxel : buffer_) *table.find_or_add(table.slot_of(voxel.key)) = voxel;
  tile.is_away = false;
  away_ -= tile.voxels;
}

void SurfaceTiles::make_room(std::size_t voxels) {
  VoxelTable& table = voxels_.table();
  const auto fit = [&] { return table.size() + voxels <= table.capacity(); };
  while (!fit() && 2 * table.slots().size() <= options_.most_slots) table.grow();
  if (!fit()) drop_oldest(voxels);
  while (!fit()) table.grow();
}

/// Drops so many tiles that half of the slots are empty when the new voxels are there, as this
/// visits the whole table. What cannot be written stays.
void SurfaceTiles::drop_oldest(std::size_t voxels) {
  VoxelTable& table = voxels_.table();
  const SlotsOfTiles slots = slots_of_tiles();
  std::size_t left = table.size() + voxels;
  std::vector<std::pair<TileKey, std::size_t>> dropped;
  for (const TileKey key : oldest_first()) {
    if (left <= table.slots().size() / 2) break;
    const auto found = slots.find(key);
    dropped.emplace_back(key, found == slots.end() ? 0 : found->second.size());
    if (dropped.back().second == 0) continue;
    Tile& tile = tiles_.at(key);
    if (tile.is_changed) write(found->second, tile);
    left -= found->second.size();
  }
  for (const auto& [key, count] : dropped) {
    if (count == 0) {
      tiles_.erase(key);
      continue;
    }
    Tile& tile = tiles_.at(key);
    tile.is_away = true;
    tile.is_changed = false;
    tile.voxels = count;
    away_ += count;
  }
  table.remove_if([&](VoxelKey key) {
    const auto tile = tiles_.find(tile_of(key));
    return tile != tiles_.end() && tile->second.is_away;
  });
}

SurfaceTiles::SlotsOfTiles SurfaceTiles::slots_of_tiles() const {
  SlotsOfTiles slots_of_tile;
  const std::vector<VoxelSums>& slots = voxels_.table().slots();
  for (std::size_t slot = 0; slot < slots.size(); ++slot) {
    if (slots[slot].key == 0) continue;
    slots_of_tile[tile_of(slots[slot].key)].push_back(static_cast<std::uint32_t>(slot));
  }
  return slots_of_tile;
}

/// The tiles in the table but those of the newest request.
std::vector<SurfaceTiles::TileKey> SurfaceTiles::oldest_first() const {
  std::vector<std::pair<std::uint64_t, TileKey>> by_age;
  for (const auto& [key, tile] : tiles_) {
    if (!tile.is_away && tile.last_required < requests_) {
      by_age.emplace_back(tile.last_required, key);
    }
  }
  std::sort(by_age.begin(), by_age.end());
  std::vector<TileKey> keys;
  for (const auto& [age, key] : by_age) keys.push_back(key);
  return keys;
}

/// A tile that has outgrown its room in the file gets a new one there, which is a power of two: all
/// rooms that it ever had are then no more than twice the last one.
void SurfaceTiles::write(const std::vector<std::uint32_t>& slots, Tile& tile) {
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  const std::vector<VoxelSums>& table = voxels_.table().slots();
  buffer_.clear();
  for (const std::uint32_t slot : slots) buffer_.push_back(table[slot]);
  if (buffer_.size() > tile.room) {
    tile.offset = file_end_;
    tile.room = 1;
    while (tile.room < buffer_.size()) tile.room *= 2;
    file_end_ += tile.room * sizeof(VoxelSums);
  }
  file_->write(tile.offset, buffer_.data(), buffer_.size() * sizeof(VoxelSums));
}

}  // namespace lidar_mapping::localization
