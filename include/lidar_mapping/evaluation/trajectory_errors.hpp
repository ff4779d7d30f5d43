// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/evaluation/association.hpp"

namespace lidar_mapping::evaluation {

/// What errors amount to, in their unit. All figures are 0 without errors.
struct ErrorStatistics {
  std::size_t count = 0;  ///< number of errors
  double rmse = 0.0;      ///< root of the mean square
  double mean = 0.0;      ///< arithmetic mean
  double median = 0.0;    ///< of two in the middle their mean
  double max = 0.0;       ///< the greatest
};

/// Errors of poses or motions, in their two parts.
struct PoseErrors {
  ErrorStatistics translation_m;  ///< lengths of the errors' translations, m
  ErrorStatistics rotation_deg;   ///< angles of the errors' rotations, degrees
};

/// Statistics of errors that are not negative.
ErrorStatistics statistics_of(std::vector<double> values);

/// Absolute pose error (Sturm et al. 2012): distance and angle between estimate and truth.
PoseErrors absolute_pose_error(const std::vector<PosePair>& pairs);

/// Relative pose error (Sturm et al. 2012): of the motion over `delta_m` metres of true path from
/// every pose; from pose to pose if `delta_m` is 0.
PoseErrors relative_pose_error(const std::vector<PosePair>& pairs, double delta_m);

/// KITTI's relative errors (Geiger et al. 2012): mean over all segments of the given lengths that
/// fit into the path, started at every `step`-th pose.
struct KittiErrors {
  double translation_percent = 0.0;    ///< of the length
  double rotation_deg_per_100m = 0.0;  ///< degrees for 100 m
  std::size_t segments = 0;            ///< number of segments in the mean; 0: none fits
  std::vector<double> lengths_m;       ///< those of which at least one segment fits
};
/// The relative errors over all lengths (m) together; a `step` of 0 counts as 1, the benchmark
/// has 10.
KittiErrors kitti_errors(const std::vector<PosePair>& pairs, const std::vector<double>& lengths_m,
                         std::size_t step);

/// 100, 200 ... 800 m as in the benchmark; for paths under 400 m 50, 100, 150 and 200 m.
std::vector<double> usual_segment_lengths(const std::vector<PosePair>& pairs);

/// Length of the true path up to each pose, m.
std::vector<double> travelled_distances(const std::vector<PosePair>& pairs);

}  // namespace lidar_mapping::evaluation
