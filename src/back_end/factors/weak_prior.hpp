// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::back_end {

// Standard deviations of a prior that is as good as none. Chosen: farther than drives err, and more
// than a turn.
constexpr double kWeakStddev_m = 1e3;
constexpr double kWeakHeadingStddev_rad = 10.0;

}  // namespace lidar_mapping::back_end
