#include "search_starts.hpp"

#include <algorithm>
#include <cmath>

#include "motion_filter.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionState;

// Around a pose: ahead and behind (m), aside (m), turned (rad).
constexpr double kBehind = 2.4;
constexpr double kAhead = 6.0;
constexpr double kStep = 1.2;
constexpr double kAside = 1.2;
constexpr double kTurn = 0.6;
constexpr double kTurnStep = 0.15;

/// Between the prediction and a pose from which it is far, as after a gap, there are centers at
/// this distance (m).
constexpr double kBetween = 6.0;
constexpr int kMostBetween = 8;

// Of the first motion, m/s and m.
constexpr double kForwardSpeed = 40.0;
constexpr double kBackwardSpeed = 15.0;
constexpr double kSideSpeed = 2.0;
constexpr double kSpeedStep = 0.75;
// With few scans a second it turns by more than a match reaches (rad/s, rad).
constexpr double kTurnRate = 0.6;
constexpr double kMostTurn = 0.3;

Pose displaced(const Pose& pose, double x, double y, double yaw) {
  Vector6d d = Vector6d::Zero();
  d[0] = x;
  d[1] = y;
  d[5] = yaw;
  return perturbed(pose, d);
}

MotionState moving(const Pose& first, double x, double y, double yaw, double seconds) {
  MotionState state{first, Vector6d::Zero()};
  state.twist[0] = x / seconds;
  state.twist[1] = y / seconds;
  state.twist[5] = yaw / seconds;
  state.T_map_sensor = moved(first, state.twist, seconds);
  return state;
}

/// The prediction, the anchors, and what lies between them: after a gap the vehicle may have
/// braked. Around an anchor beside the prediction the starts would be the same.
std::vector<Pose> centers_around(const Pose& prediction, const std::vector<Pose>& anchors) {
  std::vector<Pose> centers = {prediction};
  for (const Pose& anchor : anchors) {
    const Vector6d way = difference(anchor, prediction);
    if (way.head<3>().norm() < 0.5 * kStep && way.tail<3>().norm() < 0.5 * kTurnStep) continue;
    const int parts = std::min(kMostBetween, static_cast<int>(way.head<3>().norm() / kBetween)) + 1;
    for (int part = 0; part < parts; ++part) {
      centers.push_back(perturbed(anchor, Vector6d(part * way / parts)));
    }
  }
  return centers;
}

}  // namespace

std::vector<MotionState> starts_around(const MotionState& prediction,
                                       const std::vector<Pose>& anchors) {
  std::vector<MotionState> starts;
  for (const Pose& center : centers_around(prediction.T_map_sensor, anchors)) {
    for (double x = -kBehind; x <= kAhead + 1e-9; x += kStep) {
      for (double y = -kAside; y <= kAside + 1e-9; y += kStep) {
        for (double yaw = -kTurn; yaw <= kTurn + 1e-9; yaw += kTurnStep) {
          starts.push_back({displaced(center, x, y, yaw), prediction.twist});
        }
      }
    }
  }
  return starts;
}

std::vector<MotionState> starts_at_speed(const Pose& first, double seconds) {
  std::vector<MotionState> starts = {{first, Vector6d::Zero()}};
  const double turn = std::min(kTurnRate * seconds, kMostTurn);
  const double most = kTurnStep * std::floor(turn / kTurnStep + 1e-9);
  for (double x = kSpeedStep; x < kForwardSpeed * seconds; x += kSpeedStep) {
    for (double yaw = -most; yaw <= most + 1e-9; yaw += kTurnStep) {
      starts.push_back(moving(first, x, 0.0, yaw, seconds));
    }
    if (x < kBackwardSpeed * seconds) starts.push_back(moving(first, -x, 0.0, 0.0, seconds));
  }
  for (const double side : {-1.0, 1.0}) {
    starts.push_back(moving(first, 0.0, side * kSideSpeed * seconds, 0.0, seconds));
  }
  return starts;
}

}  // namespace lidar_mapping::front_end
