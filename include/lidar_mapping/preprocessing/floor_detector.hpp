// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"

namespace lidar_mapping::preprocessing {

/// What a floor was sought in, for display; in base_link.
struct FloorPoints {
  PointCloud filtered;  ///< after height clip and normal filter
  PointCloud inliers;   ///< on the plane that was found; empty without one
};

/// Finds the floor below the vehicle: height clip, normal filter, RANSAC plane, refinement
/// (the method of hdl_graph_slam, Koide et al. 2019). No floor is no error: Floor::found.
class FloorDetector {
 public:
  explicit FloorDetector(const FloorDetectionConfig& config);

  /// The points are filled in where they are asked for.
  Floor process(const Scan& scan, FloorPoints* points = nullptr) const;

 private:
  FloorDetectionConfig config_;
};

}  // namespace lidar_mapping::preprocessing
