// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "matching/kd_tree.hpp"

namespace lidar_mapping::loop_closing {

/// Nearest points of points that move little between two searches, like those of a cloud during
/// registration. A new search is made only if the motion was large enough that another point may
/// have become the nearest one. The results are the same as with a search each time.
class CorrespondenceCache {
 public:
  /// For `count` moving points. The tree must outlive this object.
  CorrespondenceCache(const KdTree& tree, std::size_t count) : tree_(tree), cached_(count) {}

  /// The nearest point to moving point `i`, now at `p`, if it is closer than `limit` (m).
  std::optional<KdTree::Neighbour> nearest(std::size_t i, const Eigen::Vector3f& p, float limit);

 private:
  struct CachedResult {
    Eigen::Vector3f p = Eigen::Vector3f::Zero();  ///< position at the last search
    /// Difference of the distances to the second nearest and to the nearest point, m. If none was
    /// found, the radius of the search.
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
