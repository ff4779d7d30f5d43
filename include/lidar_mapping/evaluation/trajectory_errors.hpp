// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/evaluation/association.hpp"

namespace lidar_mapping::evaluation {

struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double max = 0.0;
};

struct PoseErrors {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

ErrorStatistics statistics_of(std::vector<double> values);

/// Absolute pose error (Sturm et al. 2012): distance and angle between estimate and truth.
PoseErrors absolute_pose_error(const std::vector<PosePair>& pairs);

/// Relative pose error (Sturm et al. 2012): of the motion over `delta_m` metres of true path from
/// every pose; from pose to pose if `delta_m` is 0.
PoseErrors relative_pose_error(const std::vector<PosePair>& pairs, double delta_m);

/// KITTI's relative errors (Geiger et al. 2012): mean over all segments of the given lengths that
/// fit into the path, started at every `step`-th pose.
struct KittiErrors {
  double translation_percent = 0.0;
  double rotation_deg_per_100m = 0.0;
  std::size_t segments = 0;
  std::vector<double> lengths_m;  ///< those of which at least one segment fits
};
KittiErrors kitti_errors(const std::vector<PosePair>& pairs, const std::vector<double>& lengths_m,
                         std::size_t step);

/// 100, 200 ... 800 m as in the benchmark; for paths under 400 m 50, 100, 150 and 200 m.
std::vector<double> usual_segment_lengths(const std::vector<PosePair>& pairs);

/// Way along the true path to each pose, m.
std::vector<double> travelled_distances(const std::vector<PosePair>& pairs);

}  // namespace lidar_mapping::evaluation
