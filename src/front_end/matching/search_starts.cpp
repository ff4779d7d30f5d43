// SPDX-License-Identifier: BSD-3-Clause
#include "matching/search_starts.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "motion/motion_filter.hpp"
#include "scan/displaced.hpp"

namespace lidar_mapping::front_end {
namespace {

// Search range around a pose: ahead and behind (m), sideways (m), rotated (rad). Chosen: 216 starts
// bound the time, and their steps are smaller than the convergence basin of a coarse match.
constexpr double kBehind = 2.4;
constexpr double kAhead = 6.0;
constexpr double kStep = 1.2;
constexpr double kAside = 1.2;
constexpr double kTurn = 0.6;
constexpr double kTurnStep = 0.15;

/// If the prediction is far from an anchor pose, as after a gap, centers at this distance (m) are
/// added between them. Chosen: kAhead, so that their starts meet; their number bounds the time.
constexpr double kBetween = 6.0;
constexpr int kMaxBetween = 8;

/// At a lower speed (m/s) the twist does not show the direction of travel. Chosen: below walking
/// pace the swaying of the sensor is as fast.
constexpr double kMinSpeedForCourse = 1.0;

// Search range of the first motion, m/s (144 km/h) and m. Chosen: the step is below the convergence
// basin of a match. The forward direction of the LiDAR is not known; between two of eight
// directions the error of a fast vehicle is as large as that basin.
constexpr double kMaxSpeed = 40.0;
constexpr double kSpeedStep = 0.75;
constexpr int kDirections = 8;
// With few scans per second the rotation between two scans is larger than the convergence basin of
// a match (rad/s, rad). Chosen: a car in a bend. Measured on 100 simulated starts with 16 beams and
// two scans a second: 7 are more than a metre off after 8 scans, without rotations 16.
constexpr double kTurnRate = 0.6;
constexpr double kMaxTurn = 0.3;

/// Direction of travel as an angle from x towards y; the LiDAR's x axis if the vehicle hardly
/// moves.
Eigen::Rotation2Dd heading_of(const Vector6d& twist) {
  const Eigen::Vector2d v = twist.head<2>();
  return Eigen::Rotation2Dd(v.norm() < kMinSpeedForCourse ? 0.0 : std::atan2(v.y(), v.x()));
}

MotionState moving_state(const Pose& first, const Eigen::Vector2d& distance, double yaw,
                         double seconds) {
  MotionState state{first, Vector6d::Zero()};
  state.twist.head<2>() = distance / seconds;
  state.twist[5] = yaw / seconds;
  state.T_map_sensor = moved(first, state.twist, seconds);
  return state;
}

/// The prediction, the anchors, and poses between them, because the vehicle may have braked during
/// a gap. Anchors close to the prediction are left out: they would give the same starts.
std::vector<Pose> centers_around(const Pose& prediction, const std::vector<Pose>& anchors) {
  std::vector<Pose> centers = {prediction};
  for (const Pose& anchor : anchors) {
    const Vector6d distance = difference(anchor, prediction);
    if (distance.head<3>().norm() < 0.5 * kStep && distance.tail<3>().norm() < 0.5 * kTurnStep)
      continue;
    const int parts =
        std::min(kMaxBetween, static_cast<int>(distance.head<3>().norm() / kBetween)) + 1;
    for (int part = 0; part < parts; ++part) {
      centers.push_back(perturbed(anchor, Vector6d(part * distance / parts)));
    }
  }
  return centers;
}

}  // namespace

std::vector<MotionState> starts_around(const MotionState& prediction,
                                       const std::vector<Pose>& anchors) {
  std::vector<MotionState> starts;
  const Eigen::Rotation2Dd heading = heading_of(prediction.twist);
  for (const Pose& center : centers_around(prediction.T_map_sensor, anchors)) {
    for (double x = -kBehind; x <= kAhead + 1e-9; x += kStep) {
      for (double y = -kAside; y <= kAside + 1e-9; y += kStep) {
        for (double yaw = -kTurn; yaw <= kTurn + 1e-9; yaw += kTurnStep) {
          starts.push_back(
              {displaced(center, heading * Eigen::Vector2d(x, y), yaw), prediction.twist});
        }
      }
    }
  }
  return starts;
}

std::vector<MotionState> starts_at_speed(const Pose& first, double seconds) {
  std::vector<MotionState> starts = {{first, Vector6d::Zero()}};
  const double turn = std::min(kTurnRate * seconds, kMaxTurn);
  const double max_turn = kTurnStep * std::floor(turn / kTurnStep + 1e-9);
  const double farthest = kMaxSpeed * std::min(seconds, kLongestSearchedTime);
  for (double distance = kSpeedStep; distance < farthest; distance += kSpeedStep) {
    for (int direction = 0; direction < kDirections; ++direction) {
      const Eigen::Rotation2Dd heading(2.0 * kPi / kDirections * direction);
      for (double yaw = -max_turn; yaw <= max_turn + 1e-9; yaw += kTurnStep) {
        starts.push_back(
            moving_state(first, heading * Eigen::Vector2d(distance, 0.0), yaw, seconds));
      }
    }
  }
  return starts;
}

}  // namespace lidar_mapping::front_end
