#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// Angle between neighbouring rings of a spinning sensor, rad, as its own scan shows it; 0 where no
/// rings can be told apart: many beams, a cloud thinned out, a sensor that does not spin about the
/// z axis of the cloud's frame. Points were seen from `p_base_sensor` (m, the cloud's frame).
double ring_spacing(const PointCloud& cloud, const Eigen::Vector3d& p_base_sensor);

}  // namespace lidar_mapping::front_end
