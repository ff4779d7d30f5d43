// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/loop_closing/above_ground.hpp"

#include "matching/kd_tree.hpp"

namespace lidar_mapping::loop_closing {

/// The finite positions of a cloud.
std::vector<Eigen::Vector3f> positions(const PointCloud& cloud);

/// Points with a search tree and with normals.
class SurfaceCloud {
 public:
  SurfaceCloud() = default;
  explicit SurfaceCloud(std::vector<Eigen::Vector3f> points);

  const KdTree& tree() const { return tree_; }
  /// Unit normal of a point of the tree by its ten nearest neighbours; zero if these are not in a
  /// plane. It is computed at the first call, because a match needs only some of the normals.
  /// Therefore it must be called from one thread at a time.
  const Eigen::Vector3f& normal(std::size_t index) const;

 private:
  KdTree tree_;
  mutable std::vector<Eigen::Vector3f> normals_;
  mutable std::vector<bool> is_known_;
};

}  // namespace lidar_mapping::loop_closing
