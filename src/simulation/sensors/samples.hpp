// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/simulation/drive.hpp"

#include "sensors/imu_model.hpp"

namespace lidar_mapping::simulation {

/// Geodetic origin of the map frame.
constexpr GeodeticDatum kDatum{49.011, 8.423, 116.4};

/// Samples of the IMU, one every `period`.
std::vector<ImuSample> sample_imu(const SmoothTrajectory& trajectory, const Pose& T_base_imu,
                                  const ImuModel& model, Stamp period, std::uint64_t seed);
std::vector<VelocitySample> sample_velocity(const SmoothTrajectory& trajectory,
                                            const Pose& T_base_imu, std::uint64_t seed);
/// Fixes of the antenna; `outages` holds all intervals without a fix, those of the options and
/// those of the world.
std::vector<GnssFix> sample_gnss(const SmoothTrajectory& trajectory,
                                 const Eigen::Vector3d& p_base_antenna, double rate, double noise,
                                 const std::vector<GnssOutage>& outages,
                                 const std::vector<GnssJump>& jumps, std::uint64_t seed);

}  // namespace lidar_mapping::simulation
