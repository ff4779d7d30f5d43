// SPDX-License-Identifier: BSD-3-Clause
#include "moving_things.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr float kGroundHeight = 0.12F;  // m; what is below has no vote
constexpr float kBodyHeight = 2.5F;     // m; above are branches that join things
constexpr float kFootHeight = 0.04F;    // m; nothing below goes
constexpr float kRoof = 0.3F;           // m; ground so much above that of more key frames is none
constexpr int kFewVoters = 6;           // too few of them to take a whole thing away
constexpr float kBlockVoxel = 0.4F;     // m; neighbours decide in blocks of 3x3x3
constexpr float kSmallVoxel = 0.2F;     // m; a point is alone in 3x3x3 of them ...
constexpr int kFewAround = 2;           // ... with one other at most
constexpr double kThingCell = 0.3;      // m; cells that touch belong to one thing
constexpr double kBlockShare = 0.7;     // of a block's voters have to say that it moves
constexpr double kThingShare = 0.3;     // of a thing's: of one that stands next to nobody does

Layer layer_of(float above_own, float above_all) {
  if (above_all < kFootHeight) return Layer::kGround;
  if (above_own < kFootHeight && above_all < kGroundHeight) return Layer::kRaised;
  const float height = above_own < above_all - kRoof ? above_all : std::min(above_own, above_all);
  if (height < kGroundHeight) return Layer::kFoot;
  return height < kBodyHeight ? Layer::kBody : Layer::kHigh;
}

float height_above_all(float z, std::uint32_t column, Grounds& grounds) {
  const float near = grounds.near.height_above(z, column);
  if (near >= kGroundHeight) return near;
  const float wide = grounds.wide.height_above(z, column);
  return wide > near + kRoof ? wide : near;
}

/// Voters in some place, and those of them that say that it moves.
struct VoteCount {
  int voters = 0;
  int moving = 0;

  void add(const VoteCount& other) {
    voters += other.voters;
    moving += other.moving;
  }
  bool moves(double share) const { return static_cast<double>(moving) > share * voters; }
};

VoteCount vote_count_of(Vote vote) {
  return {vote == Vote::kUnseen ? 0 : 1, vote == Vote::kMoves ? 1 : 0};
}

/// Keys of the voxels of points, and of the columns that these stand in: of one of kColumns of a
/// pattern that repeats itself, the same for all voxels of a column.
class VoxelKeys {
 public:
  static constexpr std::size_t kColumns = std::size_t{1} << 16U;

  VoxelKeys(const PlacedPoints& points, float voxel)
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
  static constexpr unsigned kWidth = 256;
  static std::uint16_t column(int x, int y) {
    return static_cast<std::uint16_t>(static_cast<unsigned>(x) % kWidth * kWidth +
                                      static_cast<unsigned>(y) % kWidth);
  }

  const PlacedPoints& points_;
  float scale_;
  std::vector<std::uint16_t> columns_;
};

/// Columns of voxels around some, so that few of the others are looked up in vain.
class Columns {
 public:
  /// With those up to `reach` columns away.
  void add_around(VoxelKey key, int reach) {
    const VoxelKey first = key - static_cast<VoxelKey>(reach) * (kVoxelKeyStepX + kVoxelKeyStepY);
    for (int dx = 0; dx <= 2 * reach; ++dx) {
      for (int dy = 0; dy <= 2 * reach; ++dy) {
        taken_.set(VoxelKeys::column_of_key(first + static_cast<VoxelKey>(dx) * kVoxelKeyStepX +
                                            static_cast<VoxelKey>(dy) * kVoxelKeyStepY));
      }
    }
  }
  bool may_hold(std::uint16_t column) const { return taken_[column]; }

 private:
  std::bitset<VoxelKeys::kColumns> taken_;
};

/// How many points are in the 3x3x3 small voxels around a candidate.
class NeighbourCounts {
 public:
  NeighbourCounts(const PlacedPoints& points, const std::vector<Vote>& votes)
      : keys_(points, kSmallVoxel) {
    Columns near;
    bool is_empty = true;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] != Vote::kMoves) continue;
      near.add_around(keys_.of(i), 1);
      is_empty = false;
    }
    if (is_empty) return;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (near.may_hold(keys_.column_of(i))) ++counts_[keys_.of(i)];
    }
  }

  /// Itself included.
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

/// The vote counts of the 3x3x3 voxels around each voxel that is or touches a candidate's.
class Blocks {
 public:
  Blocks(const PlacedPoints& points, const std::vector<Vote>& votes) : keys_(points, kBlockVoxel) {
    std::unordered_set<VoxelKey, VoxelKeyHash> candidates;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (votes[i] == Vote::kMoves) candidates.insert(keys_.of(i));
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

  /// Whether the 3x3x3 voxels around the i-th point together go.
  bool move_around(std::size_t i) const {
    if (!near_.may_hold(keys_.column_of(i))) return false;
    const auto block = blocks_.find(keys_.of(i));
    return block != blocks_.end() && block->second.moves(kBlockShare);
  }

 private:
  /// All that can count in a block, and some others.
  std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> counted_voxels(
      const std::vector<Vote>& votes) const {
    std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> voxels;
    if (blocks_.empty()) return voxels;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] == Vote::kUnseen || !near_.may_hold(keys_.column_of(i))) continue;
      voxels[keys_.of(i)].add(vote_count_of(votes[i]));
    }
    return voxels;
  }

  VoxelKeys keys_;
  std::unordered_map<VoxelKey, VoteCount, VoxelKeyHash> blocks_;
  Columns near_;
};

/// A set of cells.
class CellSet {
 public:
  explicit CellSet(std::size_t cells) : words_(cells / kBits + 1) {}

  void add(std::uint32_t cell) { words_[cell / kBits] |= bit(cell); }
  bool has(std::uint32_t cell) const { return (words_[cell / kBits] & bit(cell)) != 0; }

 private:
  static constexpr std::uint32_t kBits = 64;
  static std::uint64_t bit(std::uint32_t cell) { return std::uint64_t{1} << (cell % kBits); }

  std::vector<std::uint64_t> words_;
};

/// Numbers of cells, in pages that are made where one is set: most cells have none.
class CellNumbers {
 public:
  static constexpr std::uint32_t kNone = 0;

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
  static constexpr std::uint32_t kPage = 32;
  static constexpr std::uint32_t kNoPage = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> pages_;  ///< where they begin in numbers_
  std::vector<std::uint32_t> numbers_;
};

/// Things that stand alone, seen from above: cells with something on them that touch, also at
/// corners. Only those are found of which something moves.
class Things {
 public:
  Things(const PlacedPoints& points, const std::vector<Vote>& votes,
         const std::vector<Layer>& layers)
      : Things(PointCells(points, kThingCell, kFarthest), votes, layers) {}

  /// Whether the thing on which the i-th point is goes as a whole.
  bool moves(std::size_t i) const { return is_inside(i) && going_.has(cells_of_points_[i]); }

  /// Whether a thing that goes stands where the i-th point is or in a cell beside.
  bool moves_beside(std::size_t i) const {
    return is_inside(i) && beside_.has(cells_of_points_[i]);
  }

 private:
  Things(const PointCells& cells, const std::vector<Vote>& votes, const std::vector<Layer>& layers)
      : area_(CellArea(cells, [&layers](std::size_t i) { return layers[i] == Layer::kBody; })
                  .widened(1)),
        cells_of_points_(area_.numbers_of(cells)),
        taken_(area_.size()),
        things_(area_.size()),
        going_(area_.size()),
        beside_(area_.size()) {
    const auto each_body = [&](const auto& visit) {
      for (std::size_t i = 0; i < layers.size(); ++i) {
        if (layers[i] == Layer::kBody && is_inside(i)) visit(cells_of_points_[i], votes[i]);
      }
    };
    each_body([&](std::uint32_t cell, Vote) { taken_.add(cell); });
    each_body([&](std::uint32_t cell, Vote vote) {
      if (vote == Vote::kMoves && things_.at(cell) == CellNumbers::kNone) gather(cell);
    });
    each_body([&](std::uint32_t cell, Vote vote) {
      const std::uint32_t thing = things_.at(cell);
      if (thing != CellNumbers::kNone) vote_counts_[thing - 1].add(vote_count_of(vote));
    });
    for (const std::uint32_t cell : gathered_) {
      if (goes(vote_counts_[things_.at(cell) - 1])) let_go(cell);
    }
  }

  bool is_inside(std::size_t i) const { return cells_of_points_[i] != CellArea::kOutside; }

  static bool goes(const VoteCount& vote_count) {
    return vote_count.voters >= kFewVoters && vote_count.moves(kThingShare);
  }

  void gather(std::uint32_t first) {
    vote_counts_.emplace_back();
    const auto thing = static_cast<std::uint32_t>(vote_counts_.size());
    std::size_t next = gathered_.size();
    const auto reach = [&](std::uint32_t cell) {
      things_.set(cell, thing);
      gathered_.push_back(cell);
    };
    reach(first);
    for (; next < gathered_.size(); ++next) {
      for (const std::uint32_t cell : block_around(gathered_[next])) {
        if (taken_.has(cell) && things_.at(cell) == CellNumbers::kNone) reach(cell);
      }
    }
  }

  void let_go(std::uint32_t cell) {
    going_.add(cell);
    for (const std::uint32_t near : block_around(cell)) beside_.add(near);
  }

  /// The nine of which that is the middle; one with something on it is not at the area's edge.
  std::array<std::uint32_t, 9> block_around(std::uint32_t cell) const {
    const auto width = static_cast<std::uint32_t>(area_.width());
    std::array<std::uint32_t, 9> block{};
    for (std::uint32_t n = 0; n < 9; ++n) block[n] = cell - width - 1 + n / 3 * width + n % 3;
    return block;
  }

  const CellArea area_;
  const std::vector<std::uint32_t> cells_of_points_;
  CellSet taken_;  ///< with something on it
  CellNumbers things_;
  std::vector<std::uint32_t> gathered_;  ///< cells, thing by thing
  std::vector<VoteCount> vote_counts_;   ///< of the things, which begin with 1
  CellSet going_;
  CellSet beside_;  ///< those that go and those around
};

bool goes(std::size_t i, Layer layer, const Blocks& blocks, const Things& things) {
  switch (layer) {
    case Layer::kGround:
      return false;
    case Layer::kAlone:
      return true;
    case Layer::kRaised:
      return things.moves(i);
    case Layer::kFoot:
      return things.moves_beside(i);
    case Layer::kBody:
      return blocks.move_around(i) || things.moves(i);
    case Layer::kHigh:
      return blocks.move_around(i) && things.moves(i);
  }
  return false;
}

}  // namespace

std::vector<Layer> layers_of(const PlacedPoints& points, Grounds& grounds) {
  std::vector<Layer> layers(points.size());
  const auto origin_z = static_cast<float>(points.origin.z());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float z = origin_z + points.z[i];
    const std::uint32_t column = grounds.area.column_of(i);
    const float above_all = height_above_all(z, column, grounds);
    layers[i] = layer_of(grounds.own.height_above(z, column), above_all);
  }
  return layers;
}

std::vector<std::uint32_t> lonely_points(const PlacedPoints& points,
                                         const std::vector<Vote>& votes) {
  const NeighbourCounts neighbour_counts(points, votes);
  std::vector<std::uint32_t> lonely;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (votes[i] == Vote::kMoves && neighbour_counts.around(i) <= kFewAround)
      lonely.push_back(static_cast<std::uint32_t>(i));
  }
  return lonely;
}

std::vector<std::uint32_t> moving_points(const PlacedPoints& points, const std::vector<Vote>& votes,
                                         const std::vector<Layer>& layers) {
  std::vector<std::uint32_t> moving;
  const Blocks blocks(points, votes);
  if (blocks.empty()) return moving;
  const Things things(points, votes, layers);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (goes(i, layers[i], blocks, things)) moving.push_back(static_cast<std::uint32_t>(i));
  }
  return moving;
}

}  // namespace lidar_mapping::moving_objects
