// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/corrected_cloud.hpp"

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/front_end/deskew.hpp"

#include "base_frame.hpp"
#include "scan/sweep_times.hpp"

namespace lidar_mapping::front_end {

PointCloud corrected_cloud(const PointCloud& cloud,
                           const std::optional<UnevenTurning>& uneven_turning,
                           const Pose& T_base_lidar, const FrontEndResult& result) {
  std::optional<UnevenTurning> turning = uneven_turning;
  if (turning) turn_axes(T_base_lidar.rotation.conjugate(), *turning);
  PointCloud points = with_right_times(cloud, turning, result.correction);
  rotate_upwards(points, result.correction.elevation_shift);
  return deskewed(transformed(points, T_base_lidar), result.twist, result.acceleration);
}

}  // namespace lidar_mapping::front_end
