// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"

#include "lru_cache.hpp"
#include "trajectory.hpp"
#include "verification.hpp"

namespace lidar_mapping::loop_closing {

/// Key frames that the scan to be matched is made of.
constexpr int kQueryKeyFrames = 3;

/// Makes what is matched: the scan of a key frame and the submap around another. Keeps a few
/// thinned clouds and submaps, so that memory does not grow with the drive.
class SubmapBuilder {
 public:
  /// Both must outlive this object.
  SubmapBuilder(const LoopClosingConfig& config, CloudSource& clouds);
  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar);

  /// Keeps the cloud of a new key frame and returns it thinned, in base_link; null if it is not to
  /// be had. If it was thinned ahead, `prepared` are its points.
  PointsPtr add_newest(const KeyFrame& key_frame, const PointsPtr& prepared = nullptr);
  /// The newest scan with those of the two nodes before, which a sensor of few beams needs.
  std::optional<QueryScan> query(const Trajectory& trajectory);
  /// The key frames within extend_frame_num of the node, as far as there are any on either side;
  /// null if the node's own cloud is not to be had.
  std::shared_ptr<const Submap> around(const Trajectory& trajectory, Trajectory::NodeId node);

 private:
  double map_leaf() const;
  double scan_leaf() const;
  Points thinned(const PointCloud& cloud, double leaf);
  PointsPtr map_points(KeyFrameIndex index);
  PointsPtr cache(KeyFrameIndex index, const PointsPtr& points);
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
  LruCache<PointsPtr> points_cache_;
  LruCache<std::shared_ptr<const Submap>> submap_cache_;
};

}  // namespace lidar_mapping::loop_closing
