// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "lidar_mapping/common/free_space_image.hpp"

#include "matching/ndt_types.hpp"
#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Finds points on what moves, such as a truck that drives alongside: they lie where scans from
/// farther back saw free space. Of a surface that slides along itself only its front does so;
/// mark_planes() adds the rest.
class MovingPointFinder {
 public:
  /// Removes all views: the poses that follow belong to another map.
  void clear() { views_.clear(); }
  /// Keeps what the scan saw as free if the sensor has moved on far enough since the last view.
  void add_view(const SampledPoints& points, const MotionState& motion);
  /// Marks the points of a scan with this motion that move; empty if they are few, such as those on
  /// a car that passes.
  PointMarks find(const SampledPoints& points, const MotionState& motion) const;

 private:
  /// A scan, in the axes of the sensor at its reference time.
  struct View {
    Pose T_map_sensor;
    FreeSpaceImage image;
  };

  std::deque<View> views_;  ///< the oldest first
};

}  // namespace lidar_mapping::front_end
