// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::tools {

/// Odometry of lidar_localization, with PCL's classes: the baseline of odometry_benchmark. At each
/// key frame the clouds of the last 20 key frames, two metres apart by Manhattan distance, are
/// merged, filtered to voxels of 0.6 m from the tenth on, and set as target of PCL's NDT; each
/// scan, filtered to voxels of 1.3 m, is matched from the pose that the last step, repeated, would
/// give. Matches are not checked, and poses are float matrices. The transformation epsilon is a
/// length as in lidar_localization: PCL 1.13 would stop after one step with its value.
///
/// It takes one scan after the other and gives pose and times of the steps; the other fields stay
/// as they are by default.
std::function<front_end::FrontEndResult(const Scan&)> baseline_odometry();

}  // namespace lidar_mapping::tools
