// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {

inline KeyFrame key_frame(std::size_t i, const Pose& T_odom_base) {
  KeyFrame result;
  result.index = static_cast<KeyFrameIndex>(i);
  result.stamp = from_seconds(0.2 * static_cast<double>(i));
  result.T_odom_base = T_odom_base;
  return result;
}

/// The results of a drive, and how they compare with the truth.
struct DriveOutcome {
  std::vector<Loop> loops;
  std::vector<LoopVerdict> verdicts;
  int false_loops = 0;
};

inline bool is_true(const Loop& loop, const std::vector<Pose>& truth) {
  const Vector6d error = difference(truth[loop.from].inverse() * truth[loop.to], loop.T_from_to);
  return error.head<3>().norm() < 0.3 && error.tail<3>().norm() < 0.03;
}

inline void append(DriveOutcome& outcome, const LoopClosingResult& result,
                   const std::vector<Pose>& truth) {
  for (const Loop& loop : result.loops) {
    outcome.loops.push_back(loop);
    if (!is_true(loop, truth)) ++outcome.false_loops;
  }
  outcome.verdicts.insert(outcome.verdicts.end(), result.verdicts.begin(), result.verdicts.end());
}

/// Drives through the world with this odometry, without a back end.
inline DriveOutcome drive(const ToyWorld& world, const std::vector<Pose>& truth,
                          const std::vector<Pose>& odometry, const LoopClosingConfig& config = {}) {
  DriveClouds clouds(world, truth);
  LoopCloser closer(config, clouds);
  closer.set_sensor_origin(ToyWorld::sensor());
  DriveOutcome outcome;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    append(outcome, closer.process(key_frame(i, odometry[i])), truth);
  }
  return outcome;
}

}  // namespace lidar_mapping::loop_closing::test
