// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"
#include "lidar_mapping/front_end/point_correction.hpp"
#include "lidar_mapping/front_end/sweep_times.hpp"

namespace lidar_mapping::front_end {

/// Times of the points of a sweep that starts at the stamp and lasts `duration` seconds, derived
/// from how a spinning sensor turns: proportional to the azimuth since the first point. The points
/// are in the axes of the sensor, z along its axis. They are stored firing by firing or ring by
/// ring, in the direction of rotation.
std::vector<float> times_by_azimuth(const PointCloud& cloud, double duration);

/// The same for points in any order, of a sensor that turns as `rotation` tells. Points without
/// coordinates have the time 0.
std::vector<float> times_by_azimuth(const PointCloud& cloud, double duration,
                                    const SensorRotation& rotation);

/// The same for points that are stored in the order in which they were measured.
std::vector<float> times_by_position(const PointCloud& cloud, double duration);

/// The times that the points have according to the rule; empty if they have none. Without times the
/// stamp is that of the begin, or of the middle if the points do not tell how the sensor turns.
std::vector<float> sweep_times(const PointCloud& cloud, const SweepTimesRule& rule);

/// The points before `turning` (in the axes of the points) was removed, if that is to be undone,
/// and with the right times; their elevations are left as they are.
PointCloud with_right_times(PointCloud cloud, const std::optional<UnevenTurning>& turning,
                            const PointCorrection& correction);

}  // namespace lidar_mapping::front_end
