#include "lidar_mapping/map/moving_objects.hpp"

#include <cmath>
#include <map>
#include <unordered_map>

#include "lidar_mapping/common/parallel.hpp"

#include "local_ground.hpp"
#include "range_image.hpp"

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kGrain = 2048;       // points
constexpr int kGroundNeighbours = 5;       // key frames whose points tell the ground
constexpr float kGroundHeight = 0.12F;     // m; what is below has no vote
constexpr float kBodyHeight = 2.5F;        // m; above are branches that join things
constexpr float kFootHeight = 0.04F;       // m; nothing below goes
constexpr float kRoof = 0.3F;              // m; own ground so much above that of all is none
constexpr double kFewVoters = 3.0;         // too few of them to take a foot away
constexpr double kBlockVoxel = 0.4;        // m; neighbours decide in blocks of 3x3x3
constexpr double kThingCell = 0.3;         // m; cells that touch belong to one thing
constexpr double kMajority = 0.5;          // of a block: all go, else none
constexpr std::size_t kKnownMarks = 2000;  // key frames whose marks are kept

/// What the neighbouring key frames say of a point.
enum Vote : char { kStands, kMoves, kUnseen };
/// Where a point is: ground, at the foot of something, on it, or above the height of vehicles.
enum Layer : char { kGround, kFoot, kBody, kHigh };

using VoxelKey = std::int64_t;

constexpr VoxelKey kRow = VoxelKey{1} << 32;

VoxelKey cell_of(const Eigen::Vector3d& p) {
  const auto cell = [](double value) {
    return static_cast<VoxelKey>(std::floor(value / kThingCell));
  };
  return cell(p.x()) * kRow + cell(p.y());
}

/// The number of the thing that each cell belongs to: cells that touch, also at corners, are one.
std::vector<std::size_t> joined(const std::unordered_map<VoxelKey, std::size_t>& cells) {
  std::vector<std::size_t> parents(cells.size());
  for (std::size_t i = 0; i < parents.size(); ++i) parents[i] = i;
  const auto root = [&](std::size_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
  };
  for (const auto& [key, number] : cells) {
    for (const VoxelKey step : {VoxelKey{1}, kRow - 1, kRow, kRow + 1}) {
      const auto neighbour = cells.find(key + step);
      if (neighbour == cells.end()) continue;
      const std::size_t a = root(number);
      const std::size_t b = root(neighbour->second);
      parents[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < parents.size(); ++i) parents[i] = root(i);
  return parents;
}

/// Voters in a block, and those of them that say that it moves.
struct Block {
  double voters = 0.0;
  double moving = 0.0;
  double share() const { return voters > 0.0 ? moving / voters : 0.0; }
};

/// A key frame as a witness: what it saw, from where.
struct View {
  Pose T_sensor_map;
  RangeImage image;
  std::vector<GroundColumn> ground;
};

std::vector<Eigen::Vector3d> in_map(const PointCloud& cloud, const Pose& T_map_base) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(cloud.size());
  for (const Point& point : cloud.points) {
    points.push_back(T_map_base * point.position().cast<double>());
  }
  return points;
}

VoxelKey block_key(const Eigen::Vector3d& p, int dx = 0, int dy = 0, int dz = 0) {
  const auto cell = [](double value, int offset) {
    return (static_cast<VoxelKey>(std::floor(value / kBlockVoxel)) + offset) & 0x1FFFFF;
  };
  return cell(p.x(), dx) << 42 | cell(p.y(), dy) << 21 | cell(p.z(), dz);
}

}  // namespace

class StaticClouds::Impl {
 public:
  Impl(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::Vector3d& p_base_sensor,
       const MovingObjectsConfig& config)
      : clouds_(clouds),
        poses_(poses.poses),
        T_base_sensor_{Eigen::Quaterniond::Identity(), p_base_sensor},
        config_(config) {
    for (std::size_t i = 0; i < poses_.size(); ++i) positions_[poses_[i].index] = i;
  }

  /// The points that move, or that do not.
  PointCloudPtr part(KeyFrameIndex index, bool moving) {
    const PointCloudPtr cloud = clouds_.cloud(index);
    const auto position = positions_.find(index);
    if (!cloud || position == positions_.end()) return cloud;
    const std::vector<bool>& moves = marks_of(position->second, *cloud);
    auto result = std::make_shared<PointCloud>();
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      if (moves[i] == moving) result->points.push_back(cloud->points[i]);
    }
    return result;
  }

 private:
  /// One mark per point; those of the last key frames are kept, a bit each, as clouds are asked for
  /// several times.
  const std::vector<bool>& marks_of(std::size_t position, const PointCloud& cloud) {
    const auto known = known_marks_.find(position);
    if (known != known_marks_.end() && known->second.size() == cloud.size()) return known->second;
    const std::vector<Eigen::Vector3d> points = in_map(cloud, poses_[position].T_map_base);
    gather_views(position);
    const std::vector<Vote> votes = votes_on(position, points);
    const std::vector<Layer> layers = layers_of(position, points);
    std::vector<bool> marks = asked_neighbours(points, votes, layers);
    take_whole_things(points, votes, layers, marks);
    if (known_marks_.size() >= kKnownMarks) known_marks_.erase(known_marks_.begin());
    return known_marks_[position] = marks;
  }

  std::size_t first_of(std::size_t position, int neighbours) const {
    const auto reach = static_cast<std::size_t>(neighbours);
    return position > reach ? position - reach : 0;
  }
  std::size_t end_of(std::size_t position, int neighbours) const {
    return std::min(poses_.size(), position + static_cast<std::size_t>(neighbours) + 1);
  }

  /// Views around a key frame; those that are far behind go.
  void gather_views(std::size_t position) {
    const std::size_t first = first_of(position, config_.neighbours);
    const std::size_t end = end_of(position, config_.neighbours);
    views_.erase(views_.begin(), views_.lower_bound(first));
    views_.erase(views_.lower_bound(end), views_.end());
    for (std::size_t i = first; i < end; ++i) {
      if (views_.count(i) > 0) continue;
      if (const PointCloudPtr cloud = clouds_.cloud(poses_[i].index)) {
        views_.emplace(i, view_of(*cloud, poses_[i].T_map_base));
      }
    }
  }

  View view_of(const PointCloud& cloud, const Pose& T_map_base) const {
    const Eigen::Vector3f origin = T_base_sensor_.translation.cast<float>();
    std::vector<Eigen::Vector3f> points;
    points.reserve(cloud.size());
    for (const Point& point : cloud.points) points.push_back(point.position() - origin);
    return {(T_map_base * T_base_sensor_).inverse(), RangeImage(points),
            ground_columns(in_map(cloud, T_map_base))};
  }

  std::vector<Vote> votes_on(std::size_t position,
                             const std::vector<Eigen::Vector3d>& points) const {
    std::vector<Vote> votes(points.size(), kUnseen);
    parallel_chunks(points.size(), kGrain, config_.threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t i = begin; i < end; ++i) {
                        votes[i] = vote_on(position, points[i]);
                      }
                    });
    return votes;
  }

  Vote vote_on(std::size_t position, const Eigen::Vector3d& p_map) const {
    int through = 0;
    int hits = 0;
    for (const auto& [witness, view] : views_) {
      if (witness == position) continue;
      const Eigen::Vector3f p_sensor = (view.T_sensor_map * p_map).cast<float>();
      if (static_cast<double>(p_sensor.squaredNorm()) > config_.reach * config_.reach) continue;
      const Sight sight = view.image.sight_of(p_sensor);
      if (sight == Sight::kSeenThrough) ++through;
      if (sight == Sight::kHit) ++hits;
    }
    if (through + hits == 0) return kUnseen;
    const bool moves =
        through >= config_.min_votes && through >= config_.min_share * (through + hits);
    return moves ? kMoves : kStands;
  }

  std::vector<Layer> layers_of(std::size_t position, const std::vector<Eigen::Vector3d>& points) {
    LocalGround ground;
    const auto end = views_.lower_bound(end_of(position, kGroundNeighbours));
    for (auto view = views_.lower_bound(first_of(position, kGroundNeighbours)); view != end;
         ++view) {
      ground.add(view->second.ground);
    }
    LocalGround own;
    const auto own_view = views_.find(position);
    if (own_view != views_.end()) own.add(own_view->second.ground);
    std::vector<Layer> layers(points.size());
    parallel_chunks(points.size(), kGrain, config_.threads,
                    [&](std::size_t begin, std::size_t stop) {
                      for (std::size_t i = begin; i < stop; ++i) {
                        layers[i] = layer_of(points[i], own, ground);
                      }
                    });
    return layers;
  }

  /// Ground is what the point's own key frame saw of it, as an error of its pose does not lift
  /// that; where that is a roof, the ground that all saw counts.
  static Layer layer_of(const Eigen::Vector3d& point, const LocalGround& own,
                        const LocalGround& all) {
    const float above_all = all.height_above(point);
    if (above_all < kFootHeight) return kGround;
    const float above_own = own.height_above(point);
    const float height = above_own < above_all - kRoof ? above_all : std::min(above_own, above_all);
    if (height < kGroundHeight) return kFoot;
    return height < kBodyHeight ? kBody : kHigh;
  }

  /// Where most of those in a block that were seen move all go, else none: also what nobody saw,
  /// and the foot of things.
  static std::vector<bool> asked_neighbours(const std::vector<Eigen::Vector3d>& points,
                                            const std::vector<Vote>& votes,
                                            const std::vector<Layer>& layers) {
    std::unordered_map<VoxelKey, Block> voxels;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] < kBody || votes[i] == kUnseen) continue;
      Block& voxel = voxels[block_key(points[i])];
      voxel.voters += 1.0;
      voxel.moving += votes[i] == kMoves ? 1.0 : 0.0;
    }
    std::unordered_map<VoxelKey, Block> blocks;
    std::vector<bool> marks(points.size(), false);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] == kGround) continue;
      const Block& block = block_around(points[i], voxels, blocks);
      const bool enough = layers[i] != kFoot || block.voters >= kFewVoters;
      marks[i] = enough && block.share() > kMajority;
    }
    return marks;
  }

  /// Things that stand alone, seen from above, go as a whole where most of what was seen of them
  /// moves.
  static void take_whole_things(const std::vector<Eigen::Vector3d>& points,
                                const std::vector<Vote>& votes, const std::vector<Layer>& layers,
                                std::vector<bool>& marks) {
    std::unordered_map<VoxelKey, std::size_t> cells;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] == kBody) cells.try_emplace(cell_of(points[i]), cells.size());
    }
    const std::vector<std::size_t> things = joined(cells);
    std::vector<Block> seen(cells.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] != kBody || votes[i] == kUnseen) continue;
      Block& thing = seen[things[cells.at(cell_of(points[i]))]];
      thing.voters += 1.0;
      thing.moving += votes[i] == kMoves ? 1.0 : 0.0;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (layers[i] != kBody && layers[i] != kFoot) continue;
      const auto cell = cells.find(cell_of(points[i]));
      if (cell == cells.end()) continue;
      const Block& thing = seen[things[cell->second]];
      if (thing.voters >= kFewVoters && thing.share() > kMajority) marks[i] = true;
    }
  }

  /// The 3x3x3 voxels around a point together; `blocks` holds those that were asked for.
  static const Block& block_around(const Eigen::Vector3d& point,
                                   const std::unordered_map<VoxelKey, Block>& voxels,
                                   std::unordered_map<VoxelKey, Block>& blocks) {
    const auto [block, is_new] = blocks.try_emplace(block_key(point));
    if (!is_new) return block->second;
    for (int n = 0; n < 27; ++n) {
      const auto voxel = voxels.find(block_key(point, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      if (voxel == voxels.end()) continue;
      block->second.voters += voxel->second.voters;
      block->second.moving += voxel->second.moving;
    }
    return block->second;
  }

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Pose T_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, std::size_t> positions_;
  std::map<std::size_t, View> views_;
  std::map<std::size_t, std::vector<bool>> known_marks_;
};

StaticClouds::StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
                           const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config)
    : impl_(std::make_unique<Impl>(clouds, poses, p_base_sensor, config)) {}
StaticClouds::~StaticClouds() = default;

PointCloudPtr StaticClouds::cloud(KeyFrameIndex index) { return impl_->part(index, false); }
PointCloudPtr StaticClouds::removed(KeyFrameIndex index) { return impl_->part(index, true); }

}  // namespace lidar_mapping::map
