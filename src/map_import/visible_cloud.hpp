// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "point_tiles.hpp"

namespace lidar_mapping::map_import {

/// Range of sight, m: that of kMaxRange in src/localization/map_surfaces.hpp, beyond which
/// localisation uses no points.
constexpr double kSight = 80.0;

/// What a LiDAR that looks in all directions would see of a map: one point for each direction of
/// half a degree, within kSight, without what other surfaces hide. The result is in base_link.
/// `resolution` is the distance of points on a surface of the map, m: nothing is seen between the
/// points of a near surface. `p_base_lidar` is in base_link, m.
PointCloud visible_cloud(const std::vector<PointTilePtr>& tiles, const Pose& T_map_base,
                         const Eigen::Vector3d& p_base_lidar, double resolution);

}  // namespace lidar_mapping::map_import
