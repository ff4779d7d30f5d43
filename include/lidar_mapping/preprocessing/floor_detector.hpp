// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"

namespace lidar_mapping::preprocessing {

/// The points in which the floor was searched, for display; in base_link.
struct FloorPoints {
  PointCloud filtered;  ///< after height clip and normal filter
  PointCloud inliers;   ///< on the plane that was found; empty if none was found
};

/// Detects the floor below the vehicle: height clip, normal filter, RANSAC plane, refinement (the
/// method of hdl_graph_slam, Koide et al. 2019). It is not an error if there is no floor: see
/// Floor::found.
class FloorDetector {
 public:
  /// The configuration is one that load() accepts.
  explicit FloorDetector(const FloorDetectionConfig& config);

  /// The floor in a scan whose points are in base_link. Fills in `points` if they are not null.
  Floor process(const Scan& scan, FloorPoints* points = nullptr) const;

 private:
  FloorDetectionConfig config_;
};

}  // namespace lidar_mapping::preprocessing
