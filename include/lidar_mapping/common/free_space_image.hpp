// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping {

/// Range image of one scan: the nearest range per direction (1.5 by 2 degrees). A point contradicts
/// the scan if it is clearly nearer than all ranges around its direction: the space there was free.
class FreeSpaceImage {
 public:
  /// Without returns: nothing is tested.
  FreeSpaceImage() = default;
  /// Points and position of the sensor in the same frame, m.
  FreeSpaceImage(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor);

  /// What the scan says of a point.
  enum class FreeSpaceTest {
    kUntested,    ///< too few returns around its direction
    kConsistent,  ///< the scan saw nothing there, or was hidden from it
    kViolation,   ///< the scan saw through it
  };
  /// Tests a point in the same frame. The point is untested unless its own cell has a return and
  /// the 3 x 3 block around it at least four.
  FreeSpaceTest test_free_space(const Eigen::Vector3f& p) const;
  /// True if the point is a violation and each of the three rows around it has a return. At the
  /// edge of the field of view, where one has none, the ground may lie between the last return and
  /// the point.
  bool is_certain_violation(const Eigen::Vector3f& p) const;

 private:
  struct Cell {
    int row = -1;
    int column = 0;
    float range = 0.0F;
  };
  /// What lies in the 3 x 3 cells around a cell.
  struct Block {
    float nearest = 0.0F;  ///< m; infinity without returns
    int returns = 0;       ///< cells that have one
    int rows = 0;          ///< rows that have one
  };
  Cell cell_of(const Eigen::Vector3f& p) const;
  Block block_around(const Cell& cell) const;

  Eigen::Vector3f sensor_ = Eigen::Vector3f::Zero();
  std::vector<float> ranges_;  ///< row by row; infinity without a return
};

}  // namespace lidar_mapping
