// SPDX-License-Identifier: BSD-3-Clause
#include "motion/drone_motion.hpp"

#include <cmath>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "motion/smoothing.hpp"
#include "scenarios/scenario.hpp"

namespace lidar_mapping::simulation {

namespace {

// Dimensions of the flight, chosen as those of a small drone that maps in a hurry.
constexpr double kStep = Track::kStep;  ///< s
constexpr double kHeightAtRest = 0.2;   ///< Height of base_link above the ground at rest, m.
constexpr double kFlightHeight = 3.0;   ///< Mean height above the ground, m.
constexpr double kWaveAmplitude = 0.8;  ///< Amplitude of vertical oscillations, m.
constexpr double kWaveHz = 0.22;        ///< Frequency of these oscillations, Hz; chosen.
constexpr double kTakeOff = 3.0;        ///< Duration of the take-off and of the landing, s.
constexpr double kTiltDuration = 1.0;   ///< Duration of a short roll or pitch, s.
constexpr double kTiltAngle = 0.5;      ///< Largest angle of one, rad (29 degrees); chosen.
constexpr double kTiltPeriod = 4.0;     ///< s

/// Fraction of the flight height: 0 on the ground, 1 in flight.
double flight_fraction(double seconds, double end) {
  return smooth_step((seconds - 3.0) / kTakeOff) * smooth_step((end - 2.0 - seconds) / kTakeOff);
}

/// x, y, z and yaw of the drone.
std::vector<Vector6d> positions(const Track& track, const std::vector<Ground>& ground,
                                Random& random) {
  const double phase = random.uniform(0.0, 2.0 * kPi);
  std::vector<Vector6d> positions(track.states().size(), Vector6d::Zero());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const TrackState& state = track.states()[i];
    const double t = static_cast<double>(i) * kStep;
    const double up = flight_fraction(t, track.seconds());
    positions[i].head<2>() = state.position;
    positions[i](2) =
        ground[i].height + kHeightAtRest +
        up * (kFlightHeight + kWaveAmplitude * std::sin(2.0 * kPi * kWaveHz * t + phase));
    positions[i](3) = state.yaw + up * 0.4 * std::sin(1.3 * t + phase);
  }
  return smoothed(std::move(positions), static_cast<int>(std::lround(0.1 / kStep)), 3);
}

/// Adds the pitch and roll with which the thrust of the rotors gives this acceleration.
void add_tilt(const Eigen::Vector3d& acceleration, double fraction, Vector6d& position) {
  const Eigen::Vector3d thrust = Eigen::AngleAxisd(-position(3), Eigen::Vector3d::UnitZ()) *
                                 (acceleration + Eigen::Vector3d(0.0, 0.0, kGravity));
  position(4) += fraction * std::atan2(thrust.x(), thrust.z());
  position(5) -= fraction * std::asin(thrust.y() / thrust.norm());
}

void add_short_tilts(std::vector<Vector6d>& control, double end, Random& random) {
  const auto count = static_cast<std::size_t>(kTiltDuration / kStep);
  for (double t = 8.0; t < end - 8.0; t += random.uniform(0.5, 1.5) * kTiltPeriod) {
    const int axis = random.integer(4, 5);
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    const double angle = side * random.uniform(0.5, 1.0) * kTiltAngle;
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
  const std::vector<Vector6d> path = positions(track, ground, random);
  std::vector<Vector6d> control = path;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Eigen::Vector3d acceleration =
        (path[i + 1] - 2.0 * path[i] + path[i - 1]).head<3>() / (kStep * kStep);
    add_tilt(acceleration, flight_fraction(static_cast<double>(i) * kStep, track.seconds()),
             control[i]);
  }
  add_short_tilts(control, track.seconds(), random);
  return SmoothTrajectory(kDriveBegin, kStep, std::move(control));
}

}  // namespace lidar_mapping::simulation
