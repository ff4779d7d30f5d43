// SPDX-License-Identifier: BSD-3-Clause
#include "moving_points.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr float kGroundHeight = 0.12F;  // m, points below have no vote
constexpr float kBodyHeight = 2.5F;     // m, above are branches that connect objects
constexpr float kBaseHeight = 0.04F;    // m, nothing below is removed
constexpr float kRoofHeight = 0.3F;  // m, ground this much above that of more key frames is a roof
constexpr int kMinVoters = 6;        // fewer voters do not remove a whole object
constexpr float kBlockVoxel = 0.4F;  // m, neighbours decide in blocks of 3x3x3
constexpr float kSmallVoxel = 0.2F;  // m, a point is isolated in 3x3x3 of them ...
constexpr int kMaxNeighbours = 2;    // ... with one other at most
constexpr double kObjectCell = 0.3;  // m, cells that touch belong to one object
constexpr double kBlockFraction = 0.7;   // of the voters that have to vote moving in a block
constexpr double kObjectFraction = 0.3;  // the same for an object, which has no neighbours

Layer layer_of(float above_own, float above_all) {
  if (above_all < kBaseHeight) return Layer::kGround;
  if (above_own < kBaseHeight && above_all < kGroundHeight) return Layer::kRaised;
  const float height =
      above_own < above_all - kRoofHeight ? above_all : std::min(above_own, above_all);
  if (height < kGroundHeight) return Layer::kBase;
  return height < kBodyHeight ? Layer::kBody : Layer::kAbove;
}

float height_above_all(float z, std::uint32_t column, GroundModels& ground_models) {
  const float near = ground_models.near.height_above(z, column);
  if (near >= kGroundHeight) return near;
  const float wide = ground_models.wide.height_above(z, column);
  return wide > near + kRoofHeight ? wide : near;
}

/// Number of voters, and of those that vote moving.
struct VoteCount {
  int voters = 0;
  int moving = 0;

  void add(const VoteCount& other) {
    voters += other.voters;
    moving += other.moving;
  }
  bool is_moving(double fraction) const { return static_cast<double>(moving) > fraction * voters; }
};

VoteCount vote_count_of(Vote vote) {
  return {vote == Vote::kUnseen ? 0 : 1, vote == Vote::kMoving ? 1 : 0};
}

/// Keys of the voxels of points, and of the vertical columns in which these lie. Columns are
/// numbered by a pattern of kColumns that repeats itself; all voxels of a column have the same
/// number.
class VoxelKeys {
 public:
  static constexpr std::size_t kColumns = std::size_t{1} << 16U;  ///< as 16 bits number

  VoxelKeys(const TransformedPoints& points, float voxel)
      : points_(points), scale_(1.0F / voxel), columns_(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      columns_[i] = column(floor_to_int(points.x[i] * scale_), floor_to_int(points.y[i] * scale_));
    }
  }

  VoxelKey of(std::size_t i) const {
    return voxel_key(
        voxel_index(scale_ * Eigen::Vector3f(points_.x[i], points_.y[i], points_.z[i])));
  }
  std::uint16_t column_of(std::size_t i) const { return columns_[i]; }
  static std::uint16_t column_of_key(VoxelKey key) {
    const VoxelIndex voxel = voxel_index(key);
    return column(voxel.x(), voxel.y());
  }

 private:
  // Square root of kColumns: the number of a column fills 16 bits.
  static constexpr unsigned kWidth = 256;
  static std::uint16_t column(int x, int y) {
    return static_cast<std::uint16_t>(static_cast<unsigned>(x) % kWidth * kWidth +
                                      static_cast<unsigned>(y) % kWidth);
  }

  const TransformedPoints& points_;
  float scale_;
  std::vector<std::uint16_t> columns_;
};

/// Filter of columns around some voxels, which saves most look-ups of other points.
class ColumnFilter {
 public:
  /// Adds the column of a voxel and those up to `max_distance` columns away.
  void add_around(VoxelKey key, int max_distance) {
    const VoxelKey first =
        key - static_cast<VoxelKey>(max_distance) * (kVoxelKeyStepX + kVoxelKeyStepY);
    for (int dx = 0; dx <= 2 * max_distance; ++dx) {
      for (int dy = 0; dy <= 2 * max_distance; ++dy) {
        occupied_.set(VoxelKeys::column_of_key(first + static_cast<VoxelKey>(dx) * kVoxelKeyStepX +
                                               static_cast<VoxelKey>(dy) * kVoxelKeyStepY));
      }
    }
  }
  bool may_contain(std::uint16_t column) const { return occupied_[column]; }

 private:
  std::bitset<VoxelKeys::kColumns> occupied_;
};

/// Numbers of points in the 3x3x3 small voxels around candidates.
class NeighbourCounter {
 public:
  NeighbourCounter(const TransformedPoints& points, const std::vector<Vote>& votes)
      : keys_(points, kSmallVoxel) {
    ColumnFilter near;
    bool is_empty = true;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] != Vote::kMoving) continue;
      near.add_around(keys_.of(i), 1);
      is_empty = false;
    }
    if (is_empty) return;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (near.may_contain(keys_.column_of(i))) ++counts_[keys_.of(i)];
    }
  }

  /// Number of points around the candidate, itself included.
  int around(std::size_t candidate) const {
    int sum = 0;
    for_voxels_around(keys_.of(candidate), [&](VoxelKey near) {
      const auto count = counts_.find(near);
      if (count != counts_.end()) sum += count->second;
    });
    return sum;
  }

 private:
  VoxelKeys keys_;
  std::unordered_map<VoxelKey, int, VoxelKeyHash> counts_;
};

/// Vote counts of the 3x3x3 voxels around each voxel that contains a candidate or touches such a
/// voxel.
class VoteBlocks {
 public:
  VoteBlocks(const TransformedPoints& points, const std::vector<Vote>& votes)
      : keys_(points, kBlockVoxel) {
    std::unordered_set<VoxelKey, VoxelKeyHash> candidates;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (votes[i] == Vote::kMoving) candidates.insert(keys_.of(i));
    }
    for (const VoxelKey key : candidates) {
      near_.add_around(key, 2);
      for_voxels_around(key, [&](VoxelKey block) { blocks_.try_emplace(block); });
    }
    for (const auto& [key, voxel] : counted_voxels(votes)) {
      const VoteCount& vote_count = voxel;
      for_voxels_around(key, [&](VoxelKey near) {
        const auto block = blocks_.find(near);
        if (block != blocks_.end()) block->second.add(vote_count);
      });
    }
  }

  bool empty() const { return blocks_.empty(); }

  /// Whether the 3x3x3 voxels around the i-th point move as a whole.
  bool is_moving_around(std::size_t i) const {
    if (!near_.may_contain(keys_.column_of(i))) return false;
    const auto block = blocks_.find(keys_.of(i));
    return block != blocks_.end() && block->second.is_moving(kBlockFraction);
  }

 private:
  /// Vote counts of all voxels that may belong to a block, and of some others.
  std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> counted_voxels(
      const std::vector<Vote>& votes) const {
    std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> voxels;
    if (blocks_.empty()) return voxels;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] == Vote::kUnseen || !near_.may_contain(keys_.column_of(i))) continue;
      voxels[keys_.of(i)].add(vote_count_of(votes[i]));
    }
    return voxels;
  }

  VoxelKeys keys_;
  std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> blocks_;
  ColumnFilter near_;
};

/// A set of cells, a bit for each.
class CellSet {
 public:
  explicit CellSet(std::size_t cells) : words_(cells / kBits + 1) {}

  void add(std::uint32_t cell) { words_[cell / kBits] |= bit(cell); }
  bool has(std::uint32_t cell) const { return (words_[cell / kBits] & bit(cell)) != 0; }

 private:
  static constexpr std::uint32_t kBits = 64;  // of a word
  static std::uint64_t bit(std::uint32_t cell) { return std::uint64_t{1} << (cell % kBits); }

  std::vector<std::uint64_t> words_;
};

/// Numbers of cells, stored in pages that are created on demand, because most cells have none.
class CellNumbers {
 public:
  static constexpr std::uint32_t kNone = 0;  // numbers of objects begin with 1

  explicit CellNumbers(std::size_t cells) : pages_(cells / kPage + 1, kNoPage) {}

  void set(std::uint32_t cell, std::uint32_t number) {
    std::uint32_t& page = pages_[cell / kPage];
    if (page == kNoPage) {
      page = static_cast<std::uint32_t>(numbers_.size());
      numbers_.resize(numbers_.size() + kPage, kNone);
    }
    numbers_[page + cell % kPage] = number;
  }
  std::uint32_t at(std::uint32_t cell) const {
    const std::uint32_t page = pages_[cell / kPage];
    return page == kNoPage ? kNone : numbers_[page + cell % kPage];
  }

 private:
  // Cells, 128 bytes; chosen: memory of sparse pages against number of pages.
  static constexpr std::uint32_t kPage = 32;
  static constexpr std::uint32_t kNoPage = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> pages_;  ///< Begin of each page in numbers_.
  std::vector<std::uint32_t> numbers_;
};

/// Objects that stand alone, seen from above: occupied cells that touch, also at corners. Only
/// objects are searched of which some point is voted moving.
class RemovedObjects {
 public:
  RemovedObjects(const TransformedPoints& points, const std::vector<Vote>& votes,
                 const std::vector<Layer>& layers)
      : RemovedObjects(PointCells(points, kObjectCell, kMaxRange), votes, layers) {}

  /// Whether the object with the i-th point is removed as a whole.
  bool contains(std::size_t i) const { return is_inside(i) && removed_.has(cells_of_points_[i]); }

  /// Whether an object that is removed stands in the cell of the i-th point or in a neighbouring
  /// one.
  bool touches(std::size_t i) const {
    return is_inside(i) && removed_or_adjacent_.has(cells_of_points_[i]);
  }

 private:
  RemovedObjects(const PointCells& cells, const std::vector<Vote>& votes,
                 const std::vector<Layer>& layers)
      : area_(CellRectangle(cells, [&layers](std::size_t i) { return layers[i] == Layer::kBody; })
                  .expanded(1)),
        cells_of_points_(area_.indices_of(cells)),
        occupied_(area_.size()),
        objects_(area_.size()),
        removed_(area_.size()),
        removed_or_adjacent_(area_.size()) {
    const auto for_each_body_point = [&](const auto& visit) {
      for (std::size_t i = 0; i < layers.size(); ++i) {
        if (layers[i] == Layer::kBody && is_inside(i)) visit(cells_of_points_[i], votes[i]);
      }
    };
    for_each_body_point([&](std::uint32_t cell, Vote) { occupied_.add(cell); });
    for_each_body_point([&](std::uint32_t cell, Vote vote) {
      if (vote == Vote::kMoving && objects_.at(cell) == CellNumbers::kNone) grow_object(cell);
    });
    for_each_body_point([&](std::uint32_t cell, Vote vote) {
      const std::uint32_t object = objects_.at(cell);
      if (object != CellNumbers::kNone) vote_counts_[object - 1].add(vote_count_of(vote));
    });
    for (const std::uint32_t cell : object_cells_) {
      if (is_removed(vote_counts_[objects_.at(cell) - 1])) mark_removed(cell);
    }
  }

  bool is_inside(std::size_t i) const { return cells_of_points_[i] != CellRectangle::kOutside; }

  static bool is_removed(const VoteCount& vote_count) {
    return vote_count.voters >= kMinVoters && vote_count.is_moving(kObjectFraction);
  }

  void grow_object(std::uint32_t first) {
    vote_counts_.emplace_back();
    const auto object = static_cast<std::uint32_t>(vote_counts_.size());
    std::size_t next = object_cells_.size();
    const auto add_cell = [&](std::uint32_t cell) {
      objects_.set(cell, object);
      object_cells_.push_back(cell);
    };
    add_cell(first);
    for (; next < object_cells_.size(); ++next) {
      for (const std::uint32_t cell : block_around(object_cells_[next])) {
        if (occupied_.has(cell) && objects_.at(cell) == CellNumbers::kNone) add_cell(cell);
      }
    }
  }

  void mark_removed(std::uint32_t cell) {
    removed_.add(cell);
    for (const std::uint32_t near : block_around(cell)) removed_or_adjacent_.add(near);
  }

  /// The 3x3 cells around a cell; occupied cells are never at the edge of the area.
  std::array<std::uint32_t, 9> block_around(std::uint32_t cell) const {
    const auto width = static_cast<std::uint32_t>(area_.width());
    std::array<std::uint32_t, 9> block{};
    for (std::uint32_t n = 0; n < 9; ++n) block[n] = cell - width - 1 + n / 3 * width + n % 3;
    return block;
  }

  const CellRectangle area_;
  const std::vector<std::uint32_t> cells_of_points_;
  CellSet occupied_;  ///< Occupied cells.
  CellNumbers objects_;
  std::vector<std::uint32_t> object_cells_;  ///< Cells of the objects, one object after the other.
  std::vector<VoteCount> vote_counts_;  ///< Vote counts of the objects, whose numbers begin with 1.
  CellSet removed_;
  CellSet removed_or_adjacent_;  ///< Cells of removed objects and their neighbours.
};

bool is_removed(std::size_t i, Layer layer, const VoteBlocks& blocks,
                const RemovedObjects& removed_objects) {
  switch (layer) {
    case Layer::kGround:
      return false;
    case Layer::kIsolated:
      return true;
    case Layer::kRaised:
      return removed_objects.contains(i);
    case Layer::kBase:
      return removed_objects.touches(i);
    case Layer::kBody:
      return blocks.is_moving_around(i) || removed_objects.contains(i);
    case Layer::kAbove:
      return blocks.is_moving_around(i) && removed_objects.contains(i);
  }
  return false;
}

}  // namespace

std::vector<Layer> classify_layers(const TransformedPoints& points, GroundModels& ground_models) {
  std::vector<Layer> layers(points.size());
  const auto origin_z = static_cast<float>(points.origin.z());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float z = origin_z + points.z[i];
    const std::uint32_t column = ground_models.area.column_of(i);
    const float above_all = height_above_all(z, column, ground_models);
    layers[i] = layer_of(ground_models.own.height_above(z, column), above_all);
  }
  return layers;
}

std::vector<std::uint32_t> isolated_points(const TransformedPoints& points,
                                           const std::vector<Vote>& votes) {
  const NeighbourCounter neighbour_counts(points, votes);
  std::vector<std::uint32_t> isolated;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (votes[i] == Vote::kMoving && neighbour_counts.around(i) <= kMaxNeighbours)
      isolated.push_back(static_cast<std::uint32_t>(i));
  }
  return isolated;
}

std::vector<std::uint32_t> moving_points(const TransformedPoints& points,
                                         const std::vector<Vote>& votes,
                                         const std::vector<Layer>& layers) {
  std::vector<std::uint32_t> moving;
  const VoteBlocks blocks(points, votes);
  if (blocks.empty()) return moving;
  const RemovedObjects removed_objects(points, votes, layers);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_removed(i, layers[i], blocks, removed_objects))
      moving.push_back(static_cast<std::uint32_t>(i));
  }
  return moving;
}

}  // namespace lidar_mapping::moving_objects
