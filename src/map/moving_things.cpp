#include "moving_things.hpp"

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

namespace lidar_mapping::map {

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
struct Poll {
  int voters = 0;
  int moving = 0;

  void add(const Poll& other) {
    voters += other.voters;
    moving += other.moving;
  }
  bool moves(double share) const { return static_cast<double>(moving) > share * voters; }
};

Poll poll_of(Vote vote) { return {vote == Vote::kUnseen ? 0 : 1, vote == Vote::kMoves ? 1 : 0}; }

/// Voxels of a size by key; a step to a neighbour is a sum.
class VoxelKeys {
 public:
  using Key = std::int64_t;
  static constexpr Key kStepX = Key{1} << 40;
  static constexpr Key kStepY = Key{1} << 20;

  VoxelKeys(const PlacedPoints& points, float voxel) : points_(points), scale_(1.0F / voxel) {}

  Key of(std::size_t i) const {
    const auto cell = [&](float value) { return static_cast<Key>(floored(value * scale_)); };
    return cell(points_.x[i]) * kStepX + cell(points_.y[i]) * kStepY + cell(points_.z[i]);
  }

  template <typename Visitor>
  static void visit_around(Key key, const Visitor& visit) {
    for (Key dx = -1; dx <= 1; ++dx) {
      for (Key dy = -1; dy <= 1; ++dy) {
        for (Key dz = -1; dz <= 1; ++dz) visit(key + dx * kStepX + dy * kStepY + dz);
      }
    }
  }

 private:
  const PlacedPoints& points_;
  float scale_;
};

/// Columns of voxels around some, so that few of the others are looked up in vain.
class Columns {
 public:
  using Key = VoxelKeys::Key;

  /// With those up to `reach` columns away.
  void add_around(Key key, Key reach) {
    for (Key dx = -reach; dx <= reach; ++dx) {
      for (Key dy = -reach; dy <= reach; ++dy) {
        taken_.set(number_of(key + dx * VoxelKeys::kStepX + dy * VoxelKeys::kStepY));
      }
    }
  }
  bool may_hold(Key key) const { return taken_[number_of(key)]; }

 private:
  static constexpr std::size_t kWidth = 256;

  /// The halves keep a negative cell of a lower axis from counting as one less of the next.
  static std::size_t number_of(Key key) {
    const auto cells =
        static_cast<std::uint64_t>(key + VoxelKeys::kStepX / 2 + VoxelKeys::kStepY / 2);
    return cells / VoxelKeys::kStepX % kWidth * kWidth + cells / VoxelKeys::kStepY % kWidth;
  }

  std::bitset<kWidth * kWidth> taken_;
};

/// How many points are in the 3x3x3 small voxels around a candidate.
class Crowds {
 public:
  Crowds(const PlacedPoints& points, const std::vector<Vote>& votes) : keys_(points, kSmallVoxel) {
    Columns near;
    bool is_empty = true;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] != Vote::kMoves) continue;
      near.add_around(keys_.of(i), 1);
      is_empty = false;
    }
    if (is_empty) return;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const VoxelKeys::Key key = keys_.of(i);
      if (near.may_hold(key)) ++counts_[key];
    }
  }

  /// Itself included.
  int around(std::size_t candidate) const {
    int sum = 0;
    VoxelKeys::visit_around(keys_.of(candidate), [&](VoxelKeys::Key near) {
      const auto count = counts_.find(near);
      if (count != counts_.end()) sum += count->second;
    });
    return sum;
  }

 private:
  VoxelKeys keys_;
  std::unordered_map<VoxelKeys::Key, int> counts_;
};

/// The polls of the 3x3x3 voxels around each voxel that is or touches a candidate's.
class Blocks {
 public:
  Blocks(const PlacedPoints& points, const std::vector<Vote>& votes) : keys_(points, kBlockVoxel) {
    std::unordered_set<Key> candidates;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (votes[i] == Vote::kMoves) candidates.insert(keys_.of(i));
    }
    for (const Key key : candidates) {
      near_.add_around(key, 2);
      VoxelKeys::visit_around(key, [&](Key block) { blocks_.try_emplace(block); });
    }
    for (const auto& [key, voxel] : polled_voxels(votes)) {
      const Poll& poll = voxel;
      VoxelKeys::visit_around(key, [&](Key near) {
        const auto block = blocks_.find(near);
        if (block != blocks_.end()) block->second.add(poll);
      });
    }
  }

  bool empty() const { return blocks_.empty(); }

  /// Whether the 3x3x3 voxels around the i-th point together go.
  bool move_around(std::size_t i) const {
    const Key key = keys_.of(i);
    if (!near_.may_hold(key)) return false;
    const auto block = blocks_.find(key);
    return block != blocks_.end() && block->second.moves(kBlockShare);
  }

 private:
  using Key = VoxelKeys::Key;

  /// All that can count in a block, and some others.
  std::unordered_map<Key, Poll> polled_voxels(const std::vector<Vote>& votes) const {
    std::unordered_map<Key, Poll> voxels;
    if (blocks_.empty()) return voxels;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] == Vote::kUnseen) continue;
      const Key key = keys_.of(i);
      if (near_.may_hold(key)) voxels[key].add(poll_of(votes[i]));
    }
    return voxels;
  }

  VoxelKeys keys_;
  std::unordered_map<Key, Poll> blocks_;
  Columns near_;
};

/// Things that stand alone, seen from above: cells with something on them that touch, also at
/// corners. Only those are found of which something moves.
class Things {
 public:
  Things(const PlacedPoints& points, const std::vector<Vote>& votes,
         const std::vector<Layer>& layers)
      : cells_of_points_(points, kThingCell, kFarthest),
        numbers_(CellArea(cells_of_points_,
                          [&layers](std::size_t i) { return layers[i] == Layer::kBody; }),
                 kFree) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] == Layer::kBody) take(cells_of_points_.at(i), poll_of(votes[i]));
    }
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].poll.moving > 0 && cells_[i].thing == kNone) gather(i);
    }
    for (const Cell& cell : cells_) {
      if (goes(cell)) going_.set(bit_of(cell.index));
    }
  }

  /// Whether the thing on which the i-th point is goes as a whole.
  bool moves(std::size_t i) const { return moves_at(cells_of_points_.at(i)); }

  /// Whether a thing that goes stands where the i-th point is or in a cell beside.
  bool moves_beside(std::size_t i) const {
    const CellIndex at = cells_of_points_.at(i);
    for (int n = 0; n < 9; ++n) {
      if (moves_at({at.x + n % 3 - 1, at.y + n / 3 - 1})) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kFree = 0;  // nothing is there
  static constexpr int kNone = -1;
  static constexpr std::size_t kWidth = 256;

  /// With something on it.
  struct Cell {
    CellIndex index;
    int thing = kNone;
    Poll poll;
  };

  void take(const CellIndex& index, const Poll& poll) {
    std::uint32_t* number = numbers_.find(index);
    if (number == nullptr) return;
    if (*number == kFree) {
      cells_.push_back({index, kNone, {}});
      *number = static_cast<std::uint32_t>(cells_.size());
    }
    cells_[*number - 1].poll.add(poll);
  }

  bool goes(const Cell& cell) const {
    if (cell.thing == kNone) return false;
    const Poll& poll = polls_[static_cast<std::size_t>(cell.thing)];
    return poll.voters >= kFewVoters && poll.moves(kThingShare);
  }

  bool moves_at(const CellIndex& index) const {
    if (!going_[bit_of(index)]) return false;
    const std::uint32_t* number = numbers_.find(index);
    return number != nullptr && *number != kFree && goes(cells_[*number - 1]);
  }

  static std::size_t bit_of(const CellIndex& index) {
    return static_cast<unsigned>(index.x) % kWidth * kWidth +
           static_cast<unsigned>(index.y) % kWidth;
  }

  void gather(std::size_t first) {
    const auto thing = static_cast<int>(polls_.size());
    polls_.emplace_back();
    std::vector<std::size_t> open = {first};
    cells_[first].thing = thing;
    while (!open.empty()) {
      const Cell& here = cells_[open.back()];
      open.pop_back();
      polls_.back().add(here.poll);
      for (int n = 0; n < 9; ++n) {
        const std::uint32_t* number =
            numbers_.find({here.index.x + n % 3 - 1, here.index.y + n / 3 - 1});
        if (number == nullptr || *number == kFree) continue;
        Cell& next = cells_[*number - 1];
        if (next.thing != kNone) continue;
        next.thing = thing;
        open.push_back(*number - 1);
      }
    }
  }

  const PointCells cells_of_points_;
  CellGrid<std::uint32_t> numbers_;  ///< of cells_, plus 1: most cells are free
  std::vector<Cell> cells_;
  std::vector<Poll> polls_;
  std::bitset<kWidth * kWidth> going_;  ///< cells that may go: few of the others are looked up
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
  const Crowds crowds(points, votes);
  std::vector<std::uint32_t> lonely;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (votes[i] == Vote::kMoves && crowds.around(i) <= kFewAround)
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

}  // namespace lidar_mapping::map
