// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace lidar_mapping::loop_closing {

/// How far apart the newest key frame and each older one are along the constraints of the map: the
/// way driven between them, shortened where the map holds a loop. The uncertainty of their relative
/// pose grows with it. Infinite where nothing joins the two.
class Separation {
 public:
  using Link = std::pair<std::size_t, std::size_t>;  ///< two nodes that a loop joins

  /// The next key frame, `step` metres of odometry after the last; infinite if none joins them.
  void append(double step);
  /// Counts anew with these loops.
  void relink(const std::vector<Link>& links);

  double to(std::size_t node) const { return way_[node] + since_; }

 private:
  std::vector<double> step_;  // from the node before
  std::vector<double> way_;   // from the newest node when since_ was 0
  double since_ = 0.0;        // way driven since relink()
};

}  // namespace lidar_mapping::loop_closing
