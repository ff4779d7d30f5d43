// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/keyed_list.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/registration/ndt_points.hpp"

namespace lidar_mapping::localization {

/// Points of one instant, seen from a viewpoint, as the matcher reads them.
registration::NdtPoints ndt_points(const std::vector<Eigen::Vector3f>& points,
                                   const std::optional<Eigen::Vector3f>& viewpoint);

/// The points of a scan that are matched with the map.
struct ScanPoints {
  registration::NdtPoints all;  ///< one for each cube, in base_link
  /// Those of them within 40 m, by which is judged whether the map knows the place.
  registration::NdtPoints near;
  /// Those of `near` that stand above the ground, by which places are told apart.
  registration::NdtPoints structure;
};

/// Takes the points of scans that are matched. Keeps scratch memory only.
class ScanPointSampler {
 public:
  /// Samples a cloud in base_link that was measured from `p_base_lidar` (m): of at most 40,000
  /// points and 16,384 cubes, which are spread over the cloud.
  ScanPoints sample(const PointCloud& cloud, const Eigen::Vector3d& p_base_lidar);

 private:
  struct Cube {
    VoxelKey key = 0;
  };

  bool is_new_cube(const Eigen::Vector3f& p);

  KeyedList<Cube, VoxelKeyHash> cubes_;
};

}  // namespace lidar_mapping::localization
