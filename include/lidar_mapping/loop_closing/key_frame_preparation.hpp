// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/loop_closing/appearance_index.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"

namespace lidar_mapping::loop_closing {

using Points = std::vector<Eigen::Vector3f>;
using PointsPtr = std::shared_ptr<const Points>;

/// What the search makes of a key frame's cloud alone, whatever else it knows.
struct PreparedKeyFrame {
  PointsPtr points;  ///< thinned as those of a submap, in base_link
  std::optional<Appearance> appearance;
};

/// Makes it, so that it can be done ahead, beside the search for the key frame before. One thread
/// calls it.
class KeyFramePreparation {
 public:
  explicit KeyFramePreparation(const LoopClosingConfig& config);

  PreparedKeyFrame prepare(const PointCloud& cloud);
  PointsPtr thinned(const PointCloud& cloud);

 private:
  double leaf_;
  VoxelMeans voxels_;
};

}  // namespace lidar_mapping::loop_closing
