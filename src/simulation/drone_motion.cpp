// SPDX-License-Identifier: BSD-3-Clause
#include "drone_motion.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "scenario.hpp"
#include "smoothing.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kStep = Track::kStep;
constexpr double kOnItsFeet = 0.2;  ///< m of base_link above the ground
constexpr double kFlight = 3.0;     ///< m above the ground, in the mean
constexpr double kWaves = 0.8;      ///< m that it goes up and down
constexpr double kWaveHz = 0.22;
constexpr double kRise = 3.0;  ///< s, and as long to land
constexpr double kJink = 1.0;  ///< s of a short roll or pitch
constexpr double kJinkAngle = 0.5;
constexpr double kJinkEvery = 4.0;  ///< s

double eased(double u) {
  const double v = std::clamp(u, 0.0, 1.0);
  return v * v * v * (10.0 + v * (6.0 * v - 15.0));
}

/// 0 on the ground, 1 in flight.
double airborne(double seconds, double end) {
  return eased((seconds - 3.0) / kRise) * eased((end - 2.0 - seconds) / kRise);
}

/// x, y, z, yaw.
std::vector<Vector6d> places(const Track& track, const std::vector<Ground>& ground,
                             Random& random) {
  const double phase = random.uniform(0.0, 2.0 * kPi);
  std::vector<Vector6d> places(track.states().size(), Vector6d::Zero());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const TrackState& state = track.states()[i];
    const double t = static_cast<double>(i) * kStep;
    const double up = airborne(t, track.seconds());
    places[i].head<2>() = state.position;
    places[i](2) = ground[i].height + kOnItsFeet +
                   up * (kFlight + kWaves * std::sin(2.0 * kPi * kWaveHz * t + phase));
    places[i](3) = state.yaw + up * 0.4 * std::sin(1.3 * t + phase);
  }
  return smoothed(std::move(places), static_cast<int>(std::lround(0.1 / kStep)), 3);
}

/// Pitch and roll with which the rotors' push gives this acceleration.
void tilt_into(const Eigen::Vector3d& acceleration, double share, Vector6d& place) {
  const Eigen::Vector3d push = Eigen::AngleAxisd(-place(3), Eigen::Vector3d::UnitZ()) *
                               (acceleration + Eigen::Vector3d(0.0, 0.0, kGravity));
  place(4) += share * std::atan2(push.x(), push.z());
  place(5) -= share * std::asin(push.y() / push.norm());
}

void add_jinks(std::vector<Vector6d>& control, double end, Random& random) {
  const auto count = static_cast<std::size_t>(kJink / kStep);
  for (double t = 8.0; t < end - 8.0; t += random.uniform(0.5, 1.5) * kJinkEvery) {
    const int axis = random.integer(4, 5);
    const double angle = (random.chance(0.5) ? 1.0 : -1.0) * random.uniform(0.5, 1.0) * kJinkAngle;
    const auto first = static_cast<std::size_t>(t / kStep);
    for (std::size_t k = 0; k <= count; ++k) {
      const double u = static_cast<double>(k) / static_cast<double>(count);
      control[first + k](axis) +=
          1.3 * angle * std::sin(2.0 * kPi * u) * std::pow(std::sin(kPi * u), 2);
    }
  }
}

}  // namespace

SmoothTrajectory flown_trajectory(const Track& track, const std::vector<Ground>& ground,
                                  Random random) {
  const std::vector<Vector6d> way = places(track, ground, random);
  std::vector<Vector6d> control = way;
  for (std::size_t i = 1; i + 1 < way.size(); ++i) {
    const Eigen::Vector3d acceleration =
        (way[i + 1] - 2.0 * way[i] + way[i - 1]).head<3>() / (kStep * kStep);
    tilt_into(acceleration, airborne(static_cast<double>(i) * kStep, track.seconds()), control[i]);
  }
  add_jinks(control, track.seconds(), random);
  return SmoothTrajectory(kDriveBegin, kStep, std::move(control));
}

}  // namespace lidar_mapping::simulation
