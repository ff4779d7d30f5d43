// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "ndt/ndt_kernels.hpp"
#include "ndt/ndt_neighbors.hpp"

namespace lidar_mapping::registration {

/// The sums, turned from the axes of the map into those of the sensor.
NdtPart part_of(const NdtSums& sums, const Eigen::Matrix3d& R_map_sensor);

/// Normal equations of the parts of a scan. Only scratch memory is kept between calls.
class NdtParts {
 public:
  /// `planes` are those of the points at the pose at which these were rotated.
  std::vector<NdtPart> of(const NdtPoints& points, const RotatedPoints& rotated,
                          const PlaneArrays& planes, float kernel_squared,
                          const Eigen::Matrix3d& R_map_sensor);

 private:
  /// Number of arrays, by definition: those of the points (x y z) and of their planes (x y z and
  /// offset).
  static constexpr std::size_t kArrays = 7;

  void assign_parts(const NdtPoints& points, const PlaneArrays& planes);
  void sort(const RotatedPoints& rotated, const PlaneArrays& planes);

  std::vector<std::uint8_t> part_;                  ///< of each point
  std::array<std::size_t, kNdtParts + 1> begin_{};  ///< of each part in the sorted arrays
  std::array<std::vector<float>, kArrays> sorted_;
};

}  // namespace lidar_mapping::registration
