// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/packed_points.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_motion.hpp"

namespace lidar_mapping::preprocessing {

/// What the pass over the points needs to know of the configuration.
struct PassLimits {
  explicit PassLimits(const PreprocessingConfig& config);

  float near_squared;
  float far_squared;
  Eigen::Vector3f box_min;  ///< of the box on the vehicle, in base_link; empty if min = max
  Eigen::Vector3f box_max;
};

enum class PointTimesAfter { kKept, kDropped };

/// The one pass over the points of a raw scan, from where they are `packed` to the cloud, which has
/// their times and the room for them (in place with packed_in(cloud)): drops points that are not
/// finite, at the sensor itself, out of range or on the vehicle; with a `motion` (its own) it
/// moves the others to where the sensor would have seen them at the scan's stamp. Points stay in
/// the sensor's frame. Times stay with their points, or are dropped. Returns how many were not
/// finite.
std::size_t keep_and_deskew(const PackedPoints& packed, PointCloud& cloud,
                            const Pose& T_base_sensor, const PassLimits& limits,
                            const ScanMotion* motion,
                            PointTimesAfter times = PointTimesAfter::kKept);

/// The cloud's own points.
PackedPoints packed_in(const PointCloud& cloud);

/// Turns every point by `angle` (rad) upwards about the horizontal axis normal to its beam.
void correct_vertical_angle(PointCloud& cloud, double angle);

/// Seconds since the scan's start for each point of a sensor that turns once per `scan_period`,
/// from the azimuth in the sensor's frame.
void set_times_from_azimuth(PointCloud& cloud, const PreprocessingConfig& config);

}  // namespace lidar_mapping::preprocessing
