#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/loop_closing/kd_tree.hpp"

namespace lidar_mapping::loop_closing {

/// The finite positions of a cloud.
std::vector<Eigen::Vector3f> positions(const PointCloud& cloud);

/// Unit normals of the points of a tree from their ten nearest neighbours; zero where the
/// neighbourhood is no plane.
std::vector<Eigen::Vector3f> planar_normals(const KdTree& tree);

/// For each point: true if it is more than 0.6 m higher than the lowest point within about 3.75 m,
/// so that slopes count as ground too.
std::vector<bool> above_ground(const std::vector<Eigen::Vector3f>& points);

}  // namespace lidar_mapping::loop_closing
