// SPDX-License-Identifier: BSD-3-Clause
#include "motion/vehicle_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"
#include "scenarios/scenario.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kSpacing = Path::kSpacing;  ///< m
constexpr double kRestAtStart = 3.0;         ///< s; chosen: enough for the bias of a gyro
constexpr double kRestAtEnd = 2.0;           ///< s; chosen
// rad per m/s^2, of the suspension. Chosen as of a car: 2 to 3 degrees when it brakes hard.
constexpr double kPitchPerAcceleration = 0.004;
constexpr double kRollPerAcceleration = 0.006;

/// Highest speed at each node of the path within all limits.
std::vector<double> speeds(const Path& path, double begin, double end, const SpeedLimits& limits,
                           const std::vector<Halt>& halts) {
  const auto nodes = static_cast<std::size_t>((end - begin) / kSpacing) + 1;
  std::vector<double> speed(nodes, limits.speed);
  for (std::size_t i = 0; i < nodes; ++i) {
    const double curvature = std::abs(path.curvature(begin + static_cast<double>(i) * kSpacing));
    speed[i] = std::min(speed[i], std::sqrt(limits.lateral / std::max(curvature, 1e-6)));
  }
  for (const Halt& halt : halts) {
    speed[static_cast<std::size_t>((halt.station - begin) / kSpacing)] = 0.0;
  }
  speed.front() = speed.back() = 0.0;
  const double gain = 2.0 * limits.longitudinal * kSpacing;
  for (std::size_t i = 1; i < nodes; ++i) {
    speed[i] = std::min(speed[i], std::sqrt(speed[i - 1] * speed[i - 1] + gain));
  }
  for (std::size_t i = nodes - 1; i-- > 0;) {
    speed[i] = std::min(speed[i], std::sqrt(speed[i + 1] * speed[i + 1] + gain));
  }
  return speed;
}

/// Times at which each node is reached and left; these differ at a halt.
struct NodeTimes {
  std::vector<double> reached, left;
};

NodeTimes node_times(const std::vector<double>& speed, double begin,
                     const std::vector<Halt>& halts) {
  NodeTimes node_times{std::vector<double>(speed.size()), std::vector<double>(speed.size())};
  node_times.left[0] = kRestAtStart;
  for (std::size_t i = 1; i < speed.size(); ++i) {
    node_times.reached[i] = node_times.left[i - 1] + 2.0 * kSpacing / (speed[i - 1] + speed[i]);
    node_times.left[i] = node_times.reached[i];
    for (const Halt& halt : halts) {
      if (static_cast<std::size_t>((halt.station - begin) / kSpacing) == i) {
        node_times.left[i] += halt.seconds;
      }
    }
  }
  node_times.left.back() += kRestAtEnd;
  return node_times;
}

/// Slow waves along the path, which model the roughness of the road after the suspension.
class RoadVibration {
 public:
  explicit RoadVibration(Random random) {
    for (double& phase : phases_) phase = random.uniform(0.0, 2.0 * kPi);
  }
  double at(int axis, double station) const {
    constexpr std::array<double, 4> kLengths = {4.7, 7.9, 13.0, 29.0};
    double sum = 0.0;
    for (std::size_t i = 0; i < kLengths.size(); ++i) {
      sum += std::sin(2.0 * kPi * station / kLengths[i] + phases_[axis * kLengths.size() + i]);
    }
    return 0.5 * sum;
  }

 private:
  std::array<double, 12> phases_{};
};

}  // namespace

std::vector<double> stations_over_time(const Path& path, double begin, double end,
                                       const SpeedLimits& limits, const std::vector<Halt>& halts,
                                       double step) {
  const std::vector<double> speed = speeds(path, begin, end, limits, halts);
  const NodeTimes when = node_times(speed, begin, halts);
  std::vector<double> stations;
  std::size_t node = 0;
  for (double t = 0.0; t < when.left.back(); t += step) {
    while (node + 1 < speed.size() && when.left[node + 1] <= t) ++node;
    double fraction = 0.0;
    if (node + 1 < speed.size() && t > when.left[node]) {
      // Constant acceleration between nodes.
      const double total = std::max(when.reached[node + 1] - when.left[node], 1e-9);
      const double u = std::min((t - when.left[node]) / total, 1.0);
      const double v0 = speed[node], v1 = speed[node + 1];
      fraction = (v0 * u + 0.5 * (v1 - v0) * u * u) / (0.5 * (v0 + v1));
    }
    stations.push_back(begin + (static_cast<double>(node) + fraction) * kSpacing);
  }
  // A driver changes the acceleration within about a second.
  return smoothed(std::move(stations), static_cast<int>(0.25 / step), 3);
}

SmoothTrajectory vehicle_trajectory(const Path& path, const std::vector<double>& stations,
                                    const GroundUnder& ground, Random random) {
  const RoadVibration vibration(random);
  std::vector<Vector6d> control(stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double s = stations[i];
    const double before = stations[i == 0 ? 0 : i - 1];
    const double after = stations[std::min(i + 1, stations.size() - 1)];
    const double speed = 0.5 * (after - before) / kControlStep;
    const double acceleration = (after - 2.0 * s + before) / (kControlStep * kControlStep);
    const double heading = path.heading(s);
    const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading)), left(-ahead.y(), ahead.x());
    const Ground under = ground(s);
    control[i] << path.position(s), under.height + 0.004 * vibration.at(0, s), heading,
        -std::atan(under.gradient.dot(ahead)) - kPitchPerAcceleration * acceleration +
            0.0015 * vibration.at(1, s),
        std::atan(under.gradient.dot(left)) +
            kRollPerAcceleration * speed * speed * path.curvature(s) + 0.0015 * vibration.at(2, s);
  }
  return SmoothTrajectory(kDriveBegin, kControlStep, smoothed(std::move(control), 4, 3));
}

}  // namespace lidar_mapping::simulation
