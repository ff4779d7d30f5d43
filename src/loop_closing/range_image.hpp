// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// What a LiDAR saw from one place: the nearest range per direction (1.5 by 2 degrees). Points that
/// lie clearly in front of everything seen there contradict the scan.
class RangeImage {
 public:
  RangeImage() = default;
  /// Points and the sensor's position in the same frame.
  RangeImage(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor);

  enum class FreeSpaceTest { kUntested, kConsistent, kViolation };
  /// What the scan says about a point (same frame): untested unless its own cell holds a return and
  /// the 3 x 3 block around at least four.
  FreeSpaceTest test_free_space(const Eigen::Vector3f& p) const;

 private:
  struct Cell {
    int row = -1;
    int column = 0;
    float range = 0.0F;
  };
  Cell cell_of(const Eigen::Vector3f& p) const;

  Eigen::Vector3f sensor_ = Eigen::Vector3f::Zero();
  std::vector<float> ranges_;  ///< row by row; infinity where nothing returned
};

}  // namespace lidar_mapping::loop_closing
