// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

namespace lidar_mapping::simulation {

/// All parameters of a scan.
struct ScanRequest {
  const RayCaster& caster;
  const SmoothTrajectory& trajectory;
  const LidarModel& lidar;
  Pose T_base_lidar;
  std::size_t frame = 0;  ///< Number of the frame since the beginning of the drive.
  Stamp stamp = 0;
  Stamp period = 0;
  bool undistorted = false;
  bool near_objects_occlude = false;  ///< Objects nearer than the least range occlude others.
  double range_noise = 0.0;           ///< Standard deviation of the ranges, m.
  std::uint64_t noise_seed = 0;       ///< Seed of the noise of this scan.
};

SimulatedScan take_scan(const ScanRequest& request);

}  // namespace lidar_mapping::simulation
