// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Range image of one scan: the nearest range per direction (1.5 by 2 degrees). A point contradicts
/// the scan if it is clearly nearer than all ranges around its direction: the space there was free.
class FreeSpaceImage {
 public:
  FreeSpaceImage() = default;
  /// Points and position of the sensor in the same frame, m.
  FreeSpaceImage(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor);

  enum class FreeSpaceTest { kUntested, kConsistent, kViolation };
  /// Tests a point in the same frame. The point is untested unless its own cell has a return and
  /// the 3 x 3 block around it at least four.
  FreeSpaceTest test_free_space(const Eigen::Vector3f& p) const;

 private:
  struct Cell {
    int row = -1;
    int column = 0;
    float range = 0.0F;
  };
  Cell cell_of(const Eigen::Vector3f& p) const;

  Eigen::Vector3f sensor_ = Eigen::Vector3f::Zero();
  std::vector<float> ranges_;  ///< row by row; infinity without a return
};

}  // namespace lidar_mapping::loop_closing
