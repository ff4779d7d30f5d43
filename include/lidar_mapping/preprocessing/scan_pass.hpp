// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/packed_points.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_motion.hpp"

namespace lidar_mapping::preprocessing {

/// The limits that are applied to the points, from the configuration.
struct PassLimits {
  /// The limits of a configuration; without use_distance_filter only points within a centimetre of
  /// the sensor are too near.
  explicit PassLimits(const PreprocessingConfig& config);

  /// Whether a point, in the frame of its own sensor (m), is too near or too far. One that is not a
  /// number is neither.
  bool is_out_of_range(const Point& point) const {
    const float squared = point.position().squaredNorm();
    return squared < near_squared || squared > far_squared;
  }

  float near_squared;       ///< square of the least range from the sensor, m^2
  float far_squared;        ///< square of the greatest range from the sensor, m^2
  Eigen::Vector3f box_min;  ///< box around the vehicle, m, in base_link; empty if min = max
  Eigen::Vector3f box_max;  ///< its upper corner, m
};

/// What becomes of the points' times in a pass.
enum class PointTimesAfter {
  kKept,    ///< the motion is still in the points, or a part of it
  kDropped  ///< all points refer to the stamp
};

/// Filters and deskews the points of a raw scan in one pass. The points are read from `packed` and
/// written to the cloud, which has their times and room for them (packed_in(cloud) works in place).
/// Points are dropped if they are not finite, or if the sensor measured them at itself, out of
/// range or on the vehicle. With a `motion` (of the sensor), the other points are moved to where
/// the sensor would have measured them at the scan's stamp. The points stay in the sensor's frame.
/// Their times are kept or dropped. Returns the number of points that are not finite.
std::size_t keep_and_deskew(const PackedPoints& packed, PointCloud& cloud,
                            const Pose& T_base_sensor, const PassLimits& limits,
                            const ScanMotion* motion,
                            PointTimesAfter times = PointTimesAfter::kKept);

/// Refers to the cloud's own points, which have to outlive the result.
PackedPoints packed_in(const PointCloud& cloud);

/// Sets the time of each point, in seconds since the scan's start, from its azimuth in the sensor's
/// frame. The sensor makes one turn per `scan_period`.
void set_times_from_azimuth(PointCloud& cloud, const PreprocessingConfig& config);

}  // namespace lidar_mapping::preprocessing
