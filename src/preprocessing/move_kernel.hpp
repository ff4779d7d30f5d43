// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping::preprocessing {

/// Which points stay: by their squared distance from the sensor, and outside of a box in a frame of
/// its own, where `to_box` ([R | t], row-major) maps points once they are moved.
struct KeepRule {
  float near_squared;
  float far_squared;
  bool has_box;
  float box_min[3];
  float box_max[3];
  float to_box[12];
};

/// A rigid motion in the middle of a slot of time, row-major [R | t], and what a point that it
/// moved goes on by in a slot: turning x point + drift.
struct MotionSlot {
  float place[12];
  float turning[3];  ///< rad
  float drift[3];    ///< m
};

/// A motion over `count` slots of equal length; held before the first and after the last (up to
/// half a slot beyond).
struct SlottedMotion {
  const MotionSlot* slots;
  int count;
  float begin;  ///< s
  float slots_per_second;
};

/// Points as they lie in memory, x y z side by side as floats.
struct PointSource {
  const unsigned char* first;  ///< x of the first point; from each x on 16 bytes can be read
  std::size_t step;            ///< bytes from point to point
  std::size_t intensity;       ///< bytes from x to the intensity, a float
  const float* times;          ///< s, one after the other; null without times
  std::size_t count;
};

/// Room for the points that stay (x y z intensity) and for their times; it may be the source's own.
struct PointSink {
  float* points;
  float* times;
};

struct MoveResult {
  std::size_t kept;
  std::size_t not_finite;
};

/// Moves points and drops those that do not stay. With times each point moves as at its own, else
/// all by the first slot's place; times stay with their points where `keeps_times`. Points whose
/// coordinates or time are not finite are dropped.
using MoveKernel = MoveResult (*)(const PointSource& source, const PointSink& sink,
                                  const KeepRule& rule, const SlottedMotion& motion,
                                  bool keeps_times);

/// The fastest one that this processor can run; they differ by what they round, some 1e-7 of a
/// distance, and by which of two neighbouring slots they take.
MoveKernel move_kernel();
MoveKernel portable_move_kernel();
/// Null where the compiler does not know these instructions or the processor is not fast with them.
MoveKernel avx2_move_kernel();
MoveKernel avx512_move_kernel();

}  // namespace lidar_mapping::preprocessing
