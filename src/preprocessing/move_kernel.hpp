#pragma once

#include <cstddef>

namespace lidar_mapping::preprocessing {

/// Which points stay: by their squared distance from the sensor, and outside of a box in the frame
/// that they are moved to.
struct KeepRule {
  float near_squared;
  float far_squared;
  bool has_box;
  float box_min[3];
  float box_max[3];
};

/// A rigid motion at the begin of a slot of time, row-major [R | t], and its change per slot.
struct MotionSlot {
  float place[12];
  float change[12];
};

/// A motion over `count` slots of equal length; held before the first and after the last.
struct SlottedMotion {
  const MotionSlot* slots;
  int count;
  float begin;  ///< s
  float slots_per_second;
};

struct MoveResult {
  std::size_t kept;
  std::size_t not_finite;
};

/// Moves points of four floats (x y z intensity) in place and drops those that do not stay. With
/// `times` each point moves as at its time, else all by the first slot's place; times stay with
/// their points where `keeps_times`. Points whose coordinates or time are not finite are dropped.
using MoveKernel = MoveResult (*)(float* points, float* times, std::size_t count,
                                  const KeepRule& rule, const SlottedMotion& motion,
                                  bool keeps_times);

/// The fastest one that this processor can run; all give the same bits.
MoveKernel move_kernel();
MoveKernel portable_move_kernel();
/// Null where the compiler or the processor knows no AVX2.
MoveKernel avx2_move_kernel();

}  // namespace lidar_mapping::preprocessing
