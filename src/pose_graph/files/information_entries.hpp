// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::pose_graph {

/// Calls `visit` with row and column of each entry of the upper triangle of an information matrix
/// that files have, in their order.
template <typename Visit>
void visit_information(bool planar, const Visit& visit) {
  const auto is_planar = [](int i) { return i < 2 || i == 5; };  // x, y, yaw
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      if (!planar || (is_planar(row) && is_planar(column))) visit(row, column);
    }
  }
}

}  // namespace lidar_mapping::pose_graph
