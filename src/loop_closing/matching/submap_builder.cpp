// SPDX-License-Identifier: BSD-3-Clause
#include "matching/submap_builder.hpp"

#include <algorithm>

#include "matching/surface.hpp"
#include "sight.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kMaxCachedPoints =
    4'000'000;                                // 48 MB, about 300 key frames of 64 beams; chosen
constexpr std::size_t kMaxCachedSubmaps = 8;  // chosen: memory against time to build them again
// m; key frames further along the path observe other surroundings. Chosen: half of the range at
// which sensors with few beams see walls.
constexpr double kMaxPathLength = 30.0;

}  // namespace

SubmapBuilder::SubmapBuilder(const LoopClosingConfig& config, CloudSource& clouds)
    : config_(config),
      clouds_(clouds),
      preparation_(config),
      points_cache_(kMaxCachedPoints),
      submap_cache_(kMaxCachedSubmaps) {}

void SubmapBuilder::set_sensor_origin(const Eigen::Vector3d& p_base_lidar) {
  if (p_base_lidar_ == p_base_lidar.cast<float>()) return;
  p_base_lidar_ = p_base_lidar.cast<float>();
  submap_cache_.clear();
}

PointsPtr SubmapBuilder::map_points(KeyFrameIndex index) {
  if (const auto* cached = points_cache_.find(index)) return *cached;
  const PointCloudPtr cloud = clouds_.cloud(index);
  return cloud ? cached(index, preparation_.thinned(*cloud)) : nullptr;
}

PointsPtr SubmapBuilder::cached(KeyFrameIndex index, const PointsPtr& points) {
  points_cache_.insert(index, points, points->size());
  return points;
}

PointsPtr SubmapBuilder::add_newest(const KeyFrame& key_frame, const PointsPtr& prepared) {
  newest_ = key_frame.cloud ? key_frame.cloud : clouds_.cloud(key_frame.index);
  if (newest_ == nullptr) return nullptr;
  const PointsPtr points = prepared ? prepared : preparation_.thinned(*newest_);
  add_view(key_frame.segment, *points);
  return cached(key_frame.index, points);
}

void SubmapBuilder::add_view(std::uint32_t segment, const Points& points) {
  std::shared_ptr<ElevationRange>& view = views_[segment];
  if (view == nullptr) view = std::make_shared<ElevationRange>();
  view->add(points, p_base_lidar_);
}

/// The newest cloud, thinned like a scan.
Points SubmapBuilder::newest_scan(KeyFrameIndex index) {
  if (config_.scan_leaf() == config_.map_leaf()) return *map_points(index);
  return voxels_.filtered(*newest_, config_.scan_leaf());
}

/// Merges `own_points` of node `middle` with the points of the key frames around it, thinned and in
/// the base_link of `middle`. The poses come from odometry, which over some metres is better than
/// an estimate that is still changing.
Points SubmapBuilder::merged_points(const Trajectory& trajectory, Trajectory::NodeId middle,
                                    const Points& own_points, std::size_t before, std::size_t after,
                                    double leaf) {
  voxels_.reset(leaf);
  for (const auto& p : own_points) voxels_.add(p);
  const Pose T_middle_odom = trajectory[middle].T_odom_base.inverse();
  const std::size_t first = middle - std::min(before, middle);
  const std::size_t last = std::min(middle + after, trajectory.size() - 1);
  for (std::size_t id = first; id <= last; ++id) {
    if (id == middle || trajectory.path_length_between(id, middle) > kMaxPathLength) continue;
    const PointsPtr points = map_points(trajectory[id].index);
    if (!points) continue;
    const Eigen::Isometry3f T_middle_other = isometry(T_middle_odom * trajectory[id].T_odom_base);
    for (const auto& p : *points) voxels_.add(T_middle_other * p);
  }
  return voxels_.points();
}

std::shared_ptr<const SingleView> SubmapBuilder::view_of(KeyFrameIndex index) {
  const PointsPtr points = map_points(index);
  if (points == nullptr) return nullptr;
  auto view = std::make_shared<SingleView>();
  view->points = *points;
  view->above_ground = above_ground(*points);
  view->image = FreeSpaceImage(*points, p_base_lidar_);
  return view;
}

std::optional<QueryScan> SubmapBuilder::query(const Trajectory& trajectory) {
  if (newest_ == nullptr) return std::nullopt;
  const Trajectory::NodeId node = trajectory.size() - 1;
  const Points own_points = newest_scan(trajectory[node].index);
  QueryScan query;
  query.image = FreeSpaceImage(own_points, p_base_lidar_);
  query.sight = range_of_sight({own_points, above_ground(own_points)});
  query.points =
      merged_points(trajectory, node, own_points, kQueryKeyFrames - 1, 0, config_.scan_leaf());
  query.above_ground = above_ground(query.points);
  return query;
}

std::shared_ptr<const Submap> SubmapBuilder::around(const Trajectory& trajectory,
                                                    Trajectory::NodeId node) {
  const KeyFrameIndex index = trajectory[node].index;
  if (const auto* cached = submap_cache_.find(index)) return *cached;
  const PointsPtr own_points = map_points(index);
  if (own_points == nullptr) return nullptr;
  const auto extent = static_cast<std::size_t>(config_.extend_frame_num);
  auto submap = std::make_shared<Submap>();
  submap->surface = SurfaceCloud(
      merged_points(trajectory, node, *own_points, extent, extent, config_.map_leaf()));
  submap->above_ground = above_ground(submap->surface.tree().points());
  submap->image = FreeSpaceImage(*own_points, p_base_lidar_);
  submap->sight = range_of_sight({*own_points, above_ground(*own_points)});
  submap->p_base_lidar = p_base_lidar_;
  const auto view = views_.find(trajectory[node].segment);
  if (view != views_.end()) submap->view = view->second;
  submap_cache_.insert(index, submap, 1);
  return submap;
}

}  // namespace lidar_mapping::loop_closing
