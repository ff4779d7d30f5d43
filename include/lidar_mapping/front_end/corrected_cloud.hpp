// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::front_end {

/// All points of a scan in base_link as a key frame has them: changed as the front end changed them
/// before it matched them (FrontEndResult::correction), and then deskewed to the stamp. `cloud` is
/// the scan that was given to FrontEnd::process(), in the LiDAR's frame, and `uneven_turning` (axes
/// of base_link) belongs to the MotionPrior that was given with it. The result has no point times.
PointCloud corrected_cloud(const PointCloud& cloud,
                           const std::optional<UnevenTurning>& uneven_turning,
                           const Pose& T_base_lidar, const FrontEndResult& result);

}  // namespace lidar_mapping::front_end
