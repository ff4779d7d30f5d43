// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end.hpp"

#include "synthetic_drive.hpp"

namespace lidar_mapping::test {

inline void feed(back_end::BackEnd& back_end, const SyntheticDrive& drive) {
  for (const KeyFrame& key_frame : drive.key_frames) back_end.add_key_frame(key_frame);
}

/// Adds a loop from each `step`th key frame to the one a lap before.
inline void add_lap_loops(back_end::BackEnd& back_end, const SyntheticDrive& drive, int lap,
                          int step, std::mt19937& engine) {
  const int count = static_cast<int>(drive.truth.size());
  for (int i = lap; i < count; i += step) {
    EXPECT_TRUE(back_end.add_loop(make_loop(drive, i - lap, i, engine)));
  }
}

inline back_end::OptimizationReport optimize(back_end::BackEnd& back_end, bool thorough = false) {
  const auto solution = back_end::solve(*back_end.problem(thorough));
  back_end.apply(*solution);
  return back_end::report_of(*solution);
}

/// Number of loops that the graph uses, of those from `first` up to `end`.
inline std::size_t used_count(const back_end::BackEnd& back_end, std::size_t first = 0,
                              std::size_t end = std::numeric_limits<std::size_t>::max()) {
  std::size_t count = 0;
  std::size_t i = 0;
  for (const auto& [loop, used] : back_end.loops()) {
    if (used && first <= i && i < end) ++count;
    ++i;
  }
  return count;
}

/// Gives the step of odometry to the key frame `at` an error; all later poses move with it.
inline void add_wrong_step(SyntheticDrive& drive, std::size_t at, const Pose& error) {
  const Pose before = drive.key_frames[at - 1].T_odom_base;
  const Pose moved = before * error * before.inverse();
  for (std::size_t i = at; i < drive.key_frames.size(); ++i) {
    drive.key_frames[i].T_odom_base = moved * drive.key_frames[i].T_odom_base;
  }
}

/// Error of the estimate without alignment.
inline double true_rmse(const back_end::BackEnd& back_end, const SyntheticDrive& drive) {
  return position_rmse(back_end.poses().poses, drive.truth, false);
}

inline double aligned_rmse(const back_end::BackEnd& back_end, const SyntheticDrive& drive) {
  return position_rmse(back_end.poses().poses, drive.truth, true);
}

}  // namespace lidar_mapping::test
