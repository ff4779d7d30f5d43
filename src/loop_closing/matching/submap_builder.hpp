// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/lru_cache.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include "decision/verification.hpp"
#include "trajectory.hpp"

namespace lidar_mapping::loop_closing {

/// Number of key frames in the scan that is matched. Chosen: a sensor of 16 beams needs them.
constexpr int kQueryKeyFrames = 3;

/// Creates the clouds that are matched: the scan of the newest key frame, and the submap around
/// another one. It caches some thinned clouds and submaps; its memory does not grow with the drive.
class SubmapBuilder {
 public:
  /// Both must outlive this object.
  SubmapBuilder(const LoopClosingConfig& config, CloudSource& clouds);
  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar);

  /// Adds what the LiDAR of a key frame of this segment has seen, in base_link. Without it all
  /// points of a scan are expected in submaps of the segment.
  void add_view(std::uint32_t segment, const Points& points);
  /// Stores the cloud of a new key frame, adds its view, and returns it thinned, in base_link; null
  /// if the cloud is not available. `prepared` are its points if it was thinned in advance.
  PointsPtr add_newest(const KeyFrame& key_frame, const PointsPtr& prepared = nullptr);
  /// What a key frame alone sees; null if its cloud is not available.
  std::shared_ptr<const SingleView> view_of(KeyFrameIndex index);
  /// The newest scan together with those of the two previous nodes: the scan of a sensor with few
  /// beams is too sparse alone.
  std::optional<QueryScan> query(const Trajectory& trajectory);
  /// The key frames within extend_frame_num of the node on both sides, as far as they exist; null
  /// if the cloud of the node itself is not available.
  std::shared_ptr<const Submap> around(const Trajectory& trajectory, Trajectory::NodeId node);

 private:
  PointsPtr map_points(KeyFrameIndex index);
  PointsPtr cached(KeyFrameIndex index, const PointsPtr& points);
  Points newest_scan(KeyFrameIndex index);
  Points merged_points(const Trajectory& trajectory, Trajectory::NodeId middle,
                       const Points& own_points, std::size_t before, std::size_t after,
                       double leaf);

  LoopClosingConfig config_;
  CloudSource& clouds_;
  Eigen::Vector3f p_base_lidar_ = Eigen::Vector3f::Zero();
  PointCloudPtr newest_;
  KeyFramePreparation preparation_;
  VoxelMeans voxels_;
  LruCache<KeyFrameIndex, PointsPtr> points_cache_;
  LruCache<KeyFrameIndex, std::shared_ptr<const Submap>> submap_cache_;
  std::map<std::uint32_t, std::shared_ptr<ElevationRange>> views_;  ///< by segment
};

}  // namespace lidar_mapping::loop_closing
