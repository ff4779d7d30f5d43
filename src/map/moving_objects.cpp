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
constexpr float kGroundHeight = 0.12F;     // m; nothing below goes
constexpr double kBlockVoxel = 0.4;        // m; neighbours decide in blocks of 3x3x3
constexpr double kMajority = 0.5;          // of a block: all go
constexpr std::size_t kKnownMarks = 2000;  // key frames whose marks are kept
constexpr double kMinority = 0.25;         // of a block: none goes

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

using VoxelKey = std::int64_t;

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
    marks_ = candidates(position, points);
    spare_ground(position, points);
    ask_neighbours(points);
    if (known_marks_.size() >= kKnownMarks) known_marks_.erase(known_marks_.begin());
    return known_marks_[position] = std::vector<bool>(marks_.begin(), marks_.end());
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

  std::vector<char> candidates(std::size_t position,
                               const std::vector<Eigen::Vector3d>& points) const {
    std::vector<char> marks(points.size(), 0);
    parallel_chunks(points.size(), kGrain, config_.threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t i = begin; i < end; ++i) {
                        marks[i] = is_seen_through(position, points[i]) ? 1 : 0;
                      }
                    });
    return marks;
  }

  bool is_seen_through(std::size_t position, const Eigen::Vector3d& p_map) const {
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
    return through >= config_.min_votes && through >= config_.min_share * (through + hits);
  }

  void spare_ground(std::size_t position, const std::vector<Eigen::Vector3d>& points) {
    LocalGround ground;
    const auto end = views_.lower_bound(end_of(position, kGroundNeighbours));
    for (auto view = views_.lower_bound(first_of(position, kGroundNeighbours)); view != end;
         ++view) {
      ground.add(view->second.ground);
    }
    above_ground_.assign(points.size(), 1);
    parallel_chunks(points.size(), kGrain, config_.threads,
                    [&](std::size_t begin, std::size_t stop) {
                      for (std::size_t i = begin; i < stop; ++i) {
                        if (ground.height_above(points[i]) < kGroundHeight)
                          marks_[i] = above_ground_[i] = 0;
                      }
                    });
  }

  /// Where most points of a block are candidates all go, where few are none goes.
  void ask_neighbours(const std::vector<Eigen::Vector3d>& points) {
    struct Block {
      double all = 0.0;
      double marked = 0.0;
    };
    std::unordered_map<VoxelKey, Block> voxels;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (above_ground_[i] == 0) continue;
      Block& voxel = voxels[block_key(points[i])];
      voxel.all += 1.0;
      voxel.marked += marks_[i];
    }
    std::unordered_map<VoxelKey, double> shares;
    const auto share_around = [&](const Eigen::Vector3d& point) {
      const auto [share, is_new] = shares.try_emplace(block_key(point), 0.0);
      if (!is_new) return share->second;
      Block block;
      for (int n = 0; n < 27; ++n) {
        const auto voxel = voxels.find(block_key(point, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
        if (voxel == voxels.end()) continue;
        block.all += voxel->second.all;
        block.marked += voxel->second.marked;
      }
      return share->second = block.marked / block.all;
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (above_ground_[i] == 0) continue;
      const double share = share_around(points[i]);
      if (share > kMajority) marks_[i] = 1;
      if (share < kMinority) marks_[i] = 0;
    }
  }

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Pose T_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, std::size_t> positions_;
  std::map<std::size_t, View> views_;
  std::vector<char> marks_;
  std::vector<char> above_ground_;
  std::map<std::size_t, std::vector<bool>> known_marks_;
};

StaticClouds::StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
                           const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config)
    : impl_(std::make_unique<Impl>(clouds, poses, p_base_sensor, config)) {}
StaticClouds::~StaticClouds() = default;

PointCloudPtr StaticClouds::cloud(KeyFrameIndex index) { return impl_->part(index, false); }
PointCloudPtr StaticClouds::removed(KeyFrameIndex index) { return impl_->part(index, true); }

}  // namespace lidar_mapping::map
