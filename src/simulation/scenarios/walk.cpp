// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "motion/path.hpp"
#include "motion/smoothing.hpp"
#include "motion/vehicle_motion.hpp"
#include "scenarios/scenario.hpp"
#include "sensors/mounting.hpp"
#include "worlds/office.hpp"
#include "worlds/vehicles.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x500, kMotion, kPeople };

constexpr double kCarried = 1.2;  ///< Height of base_link, m; chosen: in the hands of a person.

/// Adds the way through a door, round in the room behind it and out again.
void add_room(std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& door,
              const Eigen::Vector2d& inwards) {
  // From the middle of the corridor to that of the room.
  const Eigen::Vector2d middle = door + (kOfficeCorridor + 0.5 * kOfficeRoomDepth) * inwards;
  const Eigen::Vector2d deep = door + (kOfficeCorridor + 0.5 * kOfficeRoomDepth + 1.6) * inwards;
  const Eigen::Vector2d left = 1.8 * Eigen::Vector2d(-inwards.y(), inwards.x());
  corners.insert(corners.end(), {door, middle, middle + left, deep + left, deep - left,
                                 middle - left, middle - 0.4 * inwards, door});
}

/// Corners of the walk: along the corridor, into rooms and out again, round the ring, and over the
/// first corridor again.
std::vector<Eigen::Vector2d> corners() {
  const double l = kOfficeLength, w = kOfficeWidth;
  std::vector<Eigen::Vector2d> corners = {{1.0, 0.0}};
  // The second room of the lower side, then the same at the right and above.
  add_room(corners, {9.0, 0.0}, {0.0, -1.0});
  corners.emplace_back(l, 0.0);
  add_room(corners, {l, 9.0}, {1.0, 0.0});
  corners.emplace_back(l, w);
  add_room(corners, {21.0, w}, {0.0, 1.0});
  corners.insert(corners.end(),
                 {{0.0, w}, {0.0, 0.0}, {l, -0.2}, {l, w - 0.2}, {0.2, w}, {0.2, 3.0}});
  return corners;
}

/// Adds steps and movements of the hand to a smooth walk.
SmoothTrajectory walked(const Path& path, const std::vector<double>& stations, Random random) {
  std::array<double, 8> phase{};
  for (double& p : phase) p = random.uniform(0.0, 2.0 * kPi);
  std::vector<Vector6d> control(stations.size());
  constexpr double kStride = 0.68;  // m per step; chosen as of a person who walks slowly
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double s = stations[i], t = static_cast<double>(i) * kControlStep;
    const double step = 2.0 * kPi * s / kStride;
    control[i] << path.position(s), kCarried + 0.02 * std::sin(step) + 0.01 * std::sin(1.1 * t),
        path.heading(s) + 0.04 * std::sin(0.5 * step + phase[0]) +
            0.05 * std::sin(0.9 * t + phase[1]),
        0.04 * std::sin(step + phase[2]) + 0.06 * std::sin(0.7 * t + phase[3]),
        0.03 * std::sin(0.5 * step + phase[4]) + 0.05 * std::sin(0.8 * t + phase[5]);
  }
  return SmoothTrajectory(kDriveBegin, kControlStep, smoothed(std::move(control), 4, 3));
}

/// Adds a person who walks four metres ahead.
void add_guide(World& world, const std::vector<double>& stations, const Path& path, Random random) {
  Mover ahead;
  for (std::size_t i = 0; i < stations.size(); i += 5) {
    const double s = std::min(stations[i] + 4.0, path.length());
    const Eigen::Vector2d at = path.position(s);
    ahead.T_map_shape.push_back({rotation_about_z(path.heading(s)), {at.x(), at.y(), 0.0}});
  }
  world.add(make_pedestrian(Random(random.bits())), std::move(ahead));
}

}  // namespace

Scenario make_walk(const DriveOptions& options) {
  const Path path = Path::rounded(corners(), 0.5, 0.2);
  // The yaw rate in corners is at most 1.5 rad/s: speed * curvature = lateral / speed.
  const std::vector<double> stations =
      stations_over_time(path, 0.5, path.length() - 5.0, {1.3, 1.1, 0.9},
                         {{0.3 * path.length(), 2.0}, {0.7 * path.length(), 2.0}});
  Scenario scenario{{},
                    walked(path, stations, Random(options.seed, kMotion)),
                    hand_held_mounting(),
                    {{0.0, static_cast<double>(stations.size()) * kControlStep}}};
  add_office(scenario.world.fixed, Random(options.seed, kMesh));
  if (options.movers) add_guide(scenario.world, stations, path, Random(options.seed, kPeople));
  return scenario;
}

}  // namespace lidar_mapping::simulation
