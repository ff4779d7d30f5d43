#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// Rotation of upright axes, z up, in the LiDAR's frame. These are its own as long as it spins
/// about an axis that is upright by and large. One that is mounted tilted has base_link's z; but
/// what is level must show in the scan, as base_link may be anything.
Eigen::Quaterniond upright_axes(const PointCloud& cloud, const Pose& T_base_sensor);

}  // namespace lidar_mapping::front_end
