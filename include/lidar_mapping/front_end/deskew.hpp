// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The cloud as the sensor would have measured it if all points had been measured at the stamp. The
/// sensor frame moves with a constant twist (in its own axes, m/s and rad/s). The result has no
/// point times. A cloud without point times is returned unchanged. The function works in the
/// cloud's own memory, so move the cloud into it if it is not needed any more.
PointCloud deskewed(PointCloud cloud, const Vector6d& twist, int threads = 1);
/// The same for an accelerated frame: `twist` is the twist at the stamp, and it changes by
/// `acceleration` (m/s^2 and rad/s^2) per second.
PointCloud deskewed(PointCloud cloud, const Vector6d& twist, const Vector6d& acceleration,
                    int threads = 1);

}  // namespace lidar_mapping::front_end
