// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping::preprocessing {

/// The rule which points are kept: by their squared distance from the sensor, and outside of a box
/// in a frame of its own; `to_box` ([R | t], row-major) maps points to that frame. Both apply to
/// the points as they were measured: the box is on the vehicle, which the sensor moves with.
struct KeepRule {
  float near_squared;
  float far_squared;
  bool has_box;
  float box_min[3];
  float box_max[3];
  float to_box[12];
};

/// A rigid motion in the middle of a time slot, row-major [R | t], and the further displacement of
/// a moved point per slot: turning x point + drift.
struct MotionSlot {
  float transform[12];
  float turning[3];  ///< rad
  float drift[3];    ///< m
};

/// A motion over `count` slots of equal length; constant before the first and after the last one
/// (up to half a slot beyond).
struct SlottedMotion {
  const MotionSlot* slots;
  int count;
  float begin;  ///< s
  float slots_per_second;
};

/// Points in memory, with x y z adjacent as floats.
struct PointSource {
  const unsigned char* first;  ///< x of the first point; 16 bytes can be read from each x
  std::size_t step;            ///< bytes from point to point
  std::size_t intensity;       ///< bytes from x to the intensity, a float
  const float* times;          ///< s, contiguous; null without times
  std::size_t count;
};

/// Memory for the points that are kept (x y z intensity) and for their times; it may be the
/// source's own memory.
struct PointSink {
  float* points;
  float* times;
};

struct MoveResult {
  std::size_t kept;
  std::size_t not_finite;
};

/// Moves the points and drops those that are not kept. With times, each point is moved by the
/// motion at its time, otherwise all by that of the first slot. Times are kept if `keeps_times`.
/// Points whose coordinates or time are not finite are dropped.
using MoveKernel = MoveResult (*)(const PointSource& source, const PointSink& sink,
                                  const KeepRule& rule, const SlottedMotion& motion,
                                  bool keeps_times);

/// The fastest kernel that this processor can run. The kernels differ in rounding, by about 1e-7 of
/// a distance, and in the choice between two neighbouring slots.
MoveKernel move_kernel();
MoveKernel portable_move_kernel();
/// Null if the compiler does not support these instructions, or if the processor is not fast with
/// them.
MoveKernel avx2_move_kernel();
MoveKernel avx512_move_kernel();

}  // namespace lidar_mapping::preprocessing
