// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/loop_closing/appearance_index.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"

namespace lidar_mapping::loop_closing {

/// Points in base_link, m.
using Points = std::vector<Eigen::Vector3f>;
/// Shared points that do not change.
using PointsPtr = std::shared_ptr<const Points>;

/// A pose in the precision of Points.
Eigen::Isometry3f isometry(const Pose& pose);

/// The data that the loop search computes from the cloud of a key frame alone.
struct PreparedKeyFrame {
  PointsPtr points;                      ///< thinned as for a submap, in base_link; may be null
  std::optional<Appearance> appearance;  ///< appearance of these points
};

/// Computes PreparedKeyFrame. It can run in another thread while the previous key frame is
/// searched. Each object must be called from one thread.
class KeyFramePreparation {
 public:
  /// Uses map_filter and map_leaf_size of the configuration.
  explicit KeyFramePreparation(const LoopClosingConfig& config);

  /// Thins a cloud in base_link and describes its appearance.
  PreparedKeyFrame prepare(const PointCloud& cloud);
  /// Only thins the cloud.
  PointsPtr thinned(const PointCloud& cloud);

 private:
  double leaf_;
  VoxelMeans voxels_;
};

}  // namespace lidar_mapping::loop_closing
