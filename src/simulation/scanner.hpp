// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

namespace lidar_mapping::simulation {

/// What a scan is taken of, from where and how.
struct ScanRequest {
  const RayCaster& caster;
  const SmoothTrajectory& trajectory;
  const LidarModel& lidar;
  Pose T_base_lidar;
  std::size_t frame = 0;  ///< counted from the drive's first
  Stamp stamp = 0;
  Stamp period = 0;
  bool undistorted = false;
  bool near_things_hide = false;  ///< those nearer than the least range
  double range_noise = 0.0;       ///< m
  std::uint64_t noise_seed = 0;   ///< of this scan
};

SimulatedScan take_scan(const ScanRequest& request);

}  // namespace lidar_mapping::simulation
