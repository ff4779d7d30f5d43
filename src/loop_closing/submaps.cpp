#include "lidar_mapping/loop_closing/submaps.hpp"

#include <algorithm>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/loop_closing/surface.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kMaxClouds = 64;
constexpr std::size_t kMaxSubmaps = 8;
constexpr double kSubmapWay = 30.0;  // m, further ones see other things

/// The element with that index, moved to the front; null if there is none.
template <typename List>
auto* recall(List& list, KeyFrameIndex index) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto& kept) { return kept.index == index; });
  if (found != list.end()) list.splice(list.begin(), list, found);
  return found != list.end() ? &list.front().value : nullptr;
}

template <typename List, typename Value>
void remember(List& list, KeyFrameIndex index, Value value, std::size_t limit) {
  list.push_front({index, std::move(value)});
  if (list.size() > limit) list.pop_back();
}

double leaf(FilterMethod method, double size) {
  return method == FilterMethod::kVoxel ? size : 0.0;
}

}  // namespace

Submaps::Submaps(const LoopClosingConfig& config, CloudSource& clouds)
    : config_(config), clouds_(clouds) {}

void Submaps::set_sensor_origin(const Eigen::Vector3d& p_base_lidar) {
  if (p_base_lidar_ == p_base_lidar.cast<float>()) return;
  p_base_lidar_ = p_base_lidar.cast<float>();
  kept_submaps_.clear();
}

PointCloudPtr Submaps::map_cloud(KeyFrameIndex index) {
  if (const auto* kept = recall(kept_clouds_, index)) return *kept;
  const PointCloudPtr cloud = clouds_.cloud(index);
  return cloud ? keep(index, *cloud) : nullptr;
}

PointCloudPtr Submaps::keep(KeyFrameIndex index, const PointCloud& cloud) {
  const auto filtered = std::make_shared<const PointCloud>(
      voxel_filtered(cloud, leaf(config_.map_filter, config_.map_leaf_size)));
  remember(kept_clouds_, index, PointCloudPtr(filtered), kMaxClouds);
  return filtered;
}

PointCloudPtr Submaps::take_newest(const KeyFrame& key_frame) {
  newest_ = key_frame.cloud ? key_frame.cloud : clouds_.cloud(key_frame.index);
  return newest_ ? keep(key_frame.index, *newest_) : nullptr;
}

/// The newest cloud, filtered as a scan.
PointCloud Submaps::newest_scan(KeyFrameIndex index) {
  const bool same =
      config_.scan_filter == config_.map_filter && config_.scan_leaf_size == config_.map_leaf_size;
  if (same) return *map_cloud(index);
  return voxel_filtered(*newest_, leaf(config_.scan_filter, config_.scan_leaf_size));
}

/// The clouds around `middle`, placed by odometry, which over some metres is better than any
/// estimate that still moves; in the base_link of `middle`, whose own cloud comes first.
PointCloud Submaps::joined(const Trajectory& trajectory, Trajectory::NodeId middle,
                           std::size_t before, std::size_t after) {
  PointCloud result;
  const Pose T_middle_odom = trajectory[middle].T_odom_base.inverse();
  const std::size_t first = middle - std::min(before, middle);
  const std::size_t last = std::min(middle + after, trajectory.size() - 1);
  for (std::size_t id = first; id <= last; ++id) {
    const TrajectoryNode& node = trajectory[id];
    if (id == middle || node.segment != trajectory[middle].segment) continue;
    if (std::abs(node.travelled - trajectory[middle].travelled) > kSubmapWay) continue;
    const PointCloudPtr cloud = map_cloud(node.index);
    if (cloud == nullptr) continue;
    const PointCloud moved = transformed(*cloud, T_middle_odom * node.T_odom_base);
    result.points.insert(result.points.end(), moved.points.begin(), moved.points.end());
  }
  return result;
}

std::optional<QueryScan> Submaps::query(const Trajectory& trajectory) {
  if (newest_ == nullptr) return std::nullopt;
  const Trajectory::NodeId node = trajectory.size() - 1;
  PointCloud cloud = newest_scan(trajectory[node].index);
  QueryScan query;
  query.image = RangeImage(positions(cloud), p_base_lidar_);
  const auto tail = joined(trajectory, node, kQueryKeyFrames - 1, 0).points;
  cloud.points.insert(cloud.points.end(), tail.begin(), tail.end());
  query.points =
      positions(voxel_filtered(cloud, leaf(config_.scan_filter, config_.scan_leaf_size)));
  query.above_ground = above_ground(query.points);
  return query;
}

std::shared_ptr<const Submap> Submaps::around(const Trajectory& trajectory,
                                              Trajectory::NodeId node) {
  const KeyFrameIndex index = trajectory[node].index;
  if (const auto* kept = recall(kept_submaps_, index)) return *kept;
  const PointCloudPtr own = map_cloud(index);
  if (own == nullptr) return nullptr;
  PointCloud cloud{own->points, {}};
  const auto extent = static_cast<std::size_t>(config_.extend_frame_num);
  const auto others = joined(trajectory, node, extent, extent).points;
  cloud.points.insert(cloud.points.end(), others.begin(), others.end());
  auto submap = std::make_shared<Submap>();
  submap->surface = SurfaceCloud(
      positions(voxel_filtered(cloud, leaf(config_.map_filter, config_.map_leaf_size))));
  submap->above_ground = above_ground(submap->surface.tree().points());
  submap->image = RangeImage(positions(*own), p_base_lidar_);
  submap->p_base_lidar = p_base_lidar_;
  remember(kept_submaps_, index, std::shared_ptr<const Submap>(submap), kMaxSubmaps);
  return submap;
}

}  // namespace lidar_mapping::loop_closing
