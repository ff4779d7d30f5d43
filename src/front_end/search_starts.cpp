#include "lidar_mapping/front_end/search_starts.hpp"

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

// Of the first motion, m/s and m.
constexpr double kForwardSpeed = 40.0;
constexpr double kBackwardSpeed = 15.0;
constexpr double kSideSpeed = 2.0;
constexpr double kSpeedStep = 0.75;

Pose displaced(const Pose& pose, double x, double y, double yaw) {
  Vector6d d = Vector6d::Zero();
  d[0] = x;
  d[1] = y;
  d[5] = yaw;
  return perturbed(pose, d);
}

MotionState moving(const Pose& first, double x, double y, double seconds) {
  MotionState state{displaced(first, x, y, 0.0), Vector6d::Zero()};
  state.twist[0] = x / seconds;
  state.twist[1] = y / seconds;
  return state;
}

}  // namespace

std::vector<MotionState> starts_around(const MotionState& prediction,
                                       const std::vector<Pose>& anchors) {
  std::vector<Pose> centers = {prediction.T_map_sensor};
  centers.insert(centers.end(), anchors.begin(), anchors.end());
  std::vector<MotionState> starts;
  for (const Pose& center : centers) {
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
  for (double x = kSpeedStep; x < kForwardSpeed * seconds; x += kSpeedStep) {
    starts.push_back(moving(first, x, 0.0, seconds));
    if (x < kBackwardSpeed * seconds) starts.push_back(moving(first, -x, 0.0, seconds));
  }
  for (const double side : {-1.0, 1.0}) {
    starts.push_back(moving(first, 0.0, side * kSideSpeed * seconds, seconds));
  }
  return starts;
}

}  // namespace lidar_mapping::front_end
