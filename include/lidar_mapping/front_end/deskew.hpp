// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The cloud as it would have been seen at its stamp, for a sensor frame that moves with a constant
/// twist (its own axes, m/s and rad/s). The result has no times; a cloud without times comes back
/// as it is. Works in the cloud's own memory, so give away what is not needed any more.
PointCloud deskewed(PointCloud cloud, const Vector6d& twist, int threads = 1);
/// The same for a frame that is accelerated: `twist` is that at the stamp and changes by
/// `acceleration` per second.
PointCloud deskewed(PointCloud cloud, const Vector6d& twist, const Vector6d& acceleration,
                    int threads = 1);

}  // namespace lidar_mapping::front_end
