// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The cloud as the sensor would have measured it if all points had been measured at the stamp. The
/// sensor frame has this twist at the stamp (in its own axes, m/s and rad/s), which changes by
/// `acceleration` (m/s^2 and rad/s^2) per second. The result has no point times. A cloud without
/// point times is returned unchanged. The function works in the cloud's own memory, so move the
/// cloud into it if it is not needed any more.
PointCloud deskewed(PointCloud cloud, const Vector6d& twist,
                    const Vector6d& acceleration = Vector6d::Zero(), int threads = 1);

}  // namespace lidar_mapping::front_end
