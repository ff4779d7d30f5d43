// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

#include "kd_tree.hpp"

namespace lidar_mapping::loop_closing {

/// The finite positions of a cloud.
std::vector<Eigen::Vector3f> positions(const PointCloud& cloud);

/// Points with a search tree and the normals of its planes.
class SurfaceCloud {
 public:
  SurfaceCloud() = default;
  explicit SurfaceCloud(std::vector<Eigen::Vector3f> points);

  const KdTree& tree() const { return tree_; }
  /// Unit normal of a point of the tree from its ten nearest neighbours; zero where they are no
  /// plane. It is computed when it is asked for first, as a match meets some of the points only;
  /// so one thread at a time may ask.
  const Eigen::Vector3f& normal(std::size_t index) const;

 private:
  KdTree tree_;
  mutable std::vector<Eigen::Vector3f> normals_;
  mutable std::vector<bool> is_known_;
};

/// For each point: true if it is more than 0.6 m higher than the lowest point within about 3.75 m,
/// so that slopes count as ground too.
std::vector<bool> above_ground(const std::vector<Eigen::Vector3f>& points);

}  // namespace lidar_mapping::loop_closing
