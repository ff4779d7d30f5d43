// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/front_end/front_end_config.hpp"

#include "evaluated_drive.hpp"
#include "motion/motion_filter.hpp"
#include "scan/sweep_sampler.hpp"

namespace lidar_mapping::front_end {

/// A sweep of a simulated drive as the parts of the tracker take it, with the true motion. Poses
/// are relative to the LiDAR at the stamp of the first sweep.
struct TrueSweep {
  Stamp stamp = 0;
  SweepSampler sampler{FrontEndConfig{}};
  SampledPoints dense;
  SampledPoints between_rings;
  MotionState truth;  ///< in the middle of the sweep
};

/// Sweeps [first, first + count) of a drive.
inline std::vector<TrueSweep> true_sweeps(const simulation::Drive& drive, std::size_t first,
                                          std::size_t count) {
  const auto lidar_at = [&](Stamp stamp) {
    return drive.trajectory().pose(stamp) * drive.mounting().T_base_lidar;
  };
  const Pose T_first_map = lidar_at(drive.scan_stamp(first)).inverse();
  SweepSampler sampler{FrontEndConfig{}};
  sampler.set_viewpoint_at_origin();
  std::vector<TrueSweep> sweeps;
  for (std::size_t i = 0; i < count; ++i) {
    const Scan scan = lidar_scan(drive, first + i);
    sampler.sample(scan, i);
    TrueSweep sweep;
    sweep.stamp = scan.stamp;
    sweep.dense = sampler.sample_dense(scan);
    sweep.between_rings = sampler.sample_between_rings(scan, RingSurfaces::kAll);
    sweep.sampler = sampler;
    const Stamp middle = scan.stamp + from_seconds(sampler.reference());
    const Stamp half = from_seconds(0.05);
    sweep.truth.T_map_sensor = T_first_map * lidar_at(middle);
    sweep.truth.twist = twist_between(lidar_at(middle - half), lidar_at(middle + half), 0.1);
    sweeps.push_back(std::move(sweep));
  }
  return sweeps;
}

/// Seconds from the middle of one sweep to that of another.
inline double seconds_between(const TrueSweep& from, const TrueSweep& to) {
  return to_seconds(to.stamp - from.stamp) + to.sampler.reference() - from.sampler.reference();
}

/// The covariance of a match with these standard deviations.
inline Matrix12d match_covariance(double metres, double radians, double speed, double rate) {
  Vector12d sigmas;
  for (int i = 0; i < 3; ++i) {
    sigmas[i] = metres;
    sigmas[3 + i] = radians;
    sigmas[6 + i] = speed;
    sigmas[9 + i] = rate;
  }
  return sigmas.cwiseAbs2().asDiagonal();
}

}  // namespace lidar_mapping::front_end
