// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace lidar_mapping::loop_closing {

/// How far apart the newest key frame and each older one are along the constraints of the map: the
/// way driven between them, shortened where the map holds a loop. The uncertainty of their relative
/// pose grows with it. Infinite where nothing joins the two.
class GraphDistance {
 public:
  using LoopEdge = std::pair<std::size_t, std::size_t>;  ///< two nodes that a loop joins

  /// The next key frame, `step` metres of odometry after the last; infinite if none joins them.
  void append(double step);
  /// Counts anew with these loops.
  void update_loops(const std::vector<LoopEdge>& links);

  double to(std::size_t node) const { return distance_[node] + travelled_since_update_; }

 private:
  std::vector<double> step_;             // from the node before
  std::vector<double> distance_;         // from the newest node when since_ was 0
  double travelled_since_update_ = 0.0;  // way driven since relink()
};

}  // namespace lidar_mapping::loop_closing
