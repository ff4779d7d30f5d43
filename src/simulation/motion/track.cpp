// SPDX-License-Identifier: BSD-3-Clause
#include "motion/track.hpp"

#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Largest derivative of smooth_step(), at u = 1/2, by calculus.
constexpr double kPeakOfRate = 15.0 / 8.0;

/// Stations without the rest at the beginning and end.
std::vector<double> moving_part(const std::vector<double>& stations) {
  constexpr double kAtRest = 1e-4;  // m; chosen: far below the errors of sensors
  std::vector<double> moving;
  for (const double s : stations) {
    if (s > stations.front() + kAtRest && s < stations.back() - kAtRest) moving.push_back(s);
  }
  return moving;
}

}  // namespace

Track::Track(const Eigen::Vector2d& position, double yaw) : states_{{position, yaw, 0.0}} {}

void Track::stand(double seconds) {
  states_.insert(states_.end(), static_cast<std::size_t>(std::lround(seconds / kStep)),
                 TrackState(states_.back()));
}

void Track::turn(double angle, double peak_rate) {
  TrackState state = states_.back();
  const double from = state.yaw;
  const auto steps = static_cast<int>(std::ceil(kPeakOfRate * std::abs(angle) / peak_rate / kStep));
  for (int i = 1; i <= steps; ++i) {
    state.yaw = from + angle * smooth_step(static_cast<double>(i) / steps);
    states_.push_back(state);
  }
}

void Track::walk(std::vector<Eigen::Vector2d> points, const SpeedLimits& limits,
                 const Corners& corners) {
  const TrackState start = states_.back();
  points.insert(points.begin(), start.position);
  const Path path = Path::rounded(points, corners.radius, corners.blend);
  const double turn_to_path = std::remainder(path.heading(0.0) - start.yaw, 2.0 * kPi);
  turn(turn_to_path, kDefaultYawRate);
  const double yaw_offset = start.yaw + turn_to_path - path.heading(0.0);
  for (const double s :
       moving_part(stations_over_time(path, 0.0, path.length(), limits, {}, kStep))) {
    states_.push_back({path.position(s), path.heading(s) + yaw_offset, start.distance + s});
  }
}

}  // namespace lidar_mapping::simulation
