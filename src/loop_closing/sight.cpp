// SPDX-License-Identifier: BSD-3-Clause
#include "sight.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lidar_mapping::loop_closing {

namespace {

constexpr double kFractionInSight = 0.8;  // of the cells; chosen: the rest is seen through gaps
// Of the range of sight; measured: errors grow from there on (doc/results/loop_closing.md).
constexpr double kCloseFraction = 0.125;
// Ranges of sight. Chosen: after two of them straight ahead nothing of the old view is in sight.
constexpr double kSightsBetween = 2.0;
// m. Chosen: there odometry, which errs by 1 %, has lost half a metre, far more than a loop errs.
constexpr double kMaxPathLength = 50.0;
// Of the range of sight, and m. Chosen: neighbouring loops share surfaces and therefore errors.
constexpr double kSightFractionBetween = 0.5;
constexpr double kMaxInterval = 5.0;
// Measured: matches of key frames that are not close err three to six times as much as those of
// close ones (doc/results/loop_closing.md).
constexpr double kFarGrowth = 5.0;

}  // namespace

double range_of_sight(const BirdsEyeView& view) {
  std::vector<float> distances;
  for (const Eigen::Vector2f& cell : view.cells()) distances.push_back(cell.norm());
  if (distances.empty()) return 0.0;
  // Not quantile() of common/order_statistics.hpp, whose rank is a fraction of all values: this one
  // is a fraction of those before the last, and the limits above were measured with it.
  const auto rank =
      static_cast<std::ptrdiff_t>(kFractionInSight * static_cast<double>(distances.size() - 1));
  std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
  return distances[rank];
}

double loop_distance_limit(double sight, const LoopClosingConfig& config) {
  return config.max_loop_distance >= 0.0 ? config.max_loop_distance : sight;
}

double least_path_length(double sight, const LoopClosingConfig& config) {
  if (config.accum_distance_thresh >= 0.0) return config.accum_distance_thresh;
  return std::min(kMaxPathLength, kSightsBetween * sight);
}

double search_interval(double sight, const LoopClosingConfig& config) {
  if (config.min_edge_interval >= 0.0) return config.min_edge_interval;
  return std::min(kMaxInterval, kSightFractionBetween * sight);
}

bool is_close(double distance, double sight) { return distance <= kCloseFraction * sight; }

double growth_of_error(double distance, double sight) {
  return is_close(distance, sight) ? 1.0 : kFarGrowth;
}

}  // namespace lidar_mapping::loop_closing
