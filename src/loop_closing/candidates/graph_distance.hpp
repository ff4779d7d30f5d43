// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace lidar_mapping::loop_closing {

/// Length of the shortest path along the constraints of the map between the newest key frame and
/// each older one: the distance travelled, or a shorter path through loops. The uncertainty of
/// their relative pose grows with it. Infinite if nothing connects the two.
class GraphDistance {
 public:
  using LoopEdge = std::pair<std::size_t, std::size_t>;  ///< two nodes that a loop connects

  /// Appends the next key frame after `step` metres of odometry; infinite if odometry does not
  /// connect it.
  void append(double step);
  /// Computes all distances again with these loops.
  void update_loops(const std::vector<LoopEdge>& links);

  double to(std::size_t node) const { return distance_[node] + travelled_since_update_; }

 private:
  std::vector<double> step_;  // to each node from the previous one
  // To each node from the node that was the newest at the last update.
  std::vector<double> distance_;
  double travelled_since_update_ = 0.0;  // distance travelled since update_loops()
};

}  // namespace lidar_mapping::loop_closing
