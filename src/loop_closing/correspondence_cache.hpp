// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kd_tree.hpp"

namespace lidar_mapping::loop_closing {

/// The nearest points to points that move little from one search to the next, as those of a cloud
/// do that is being matched. A search is only made where the move was large enough that another
/// point may have become the nearest; the result is that of a search each time.
class CorrespondenceCache {
 public:
  /// For `count` moving points. The tree must outlive this object.
  CorrespondenceCache(const KdTree& tree, std::size_t count) : tree_(tree), cached_(count) {}

  /// The nearest point to moving point `i`, now at `p`, that is closer than `limit` (m).
  std::optional<KdTree::Neighbour> nearest(std::size_t i, const Eigen::Vector3f& p, float limit);

 private:
  struct CachedResult {
    Eigen::Vector3f p = Eigen::Vector3f::Zero();  ///< where the point was at the last search
    /// What all others were further away than the nearest, m; without any, how far the search went.
    float margin = -1.0F;
    std::uint32_t index = 0;
    bool found = false;
  };
  void search(CachedResult& cached, const Eigen::Vector3f& p, float limit) const;
  static bool is_still_valid(const CachedResult& cached, const Eigen::Vector3f& p, float limit);

  const KdTree& tree_;
  std::vector<CachedResult> cached_;
};

}  // namespace lidar_mapping::loop_closing
