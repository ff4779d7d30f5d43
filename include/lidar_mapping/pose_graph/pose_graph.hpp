// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::pose_graph {

/// A relative pose between two nodes, with its information for g2o's error (translation and vector
/// part of the quaternion; Kuemmerle et al. 2011). In a planar graph rows and columns 0, 1 and 5
/// count and stand for x, y and the angle itself.
struct PoseEdge {
  std::int64_t from = 0;
  std::int64_t to = 0;
  Pose T_from_to;
  Matrix6d information = Matrix6d::Identity();
};

struct PoseNode {
  std::int64_t id = 0;
  Pose pose;
};

/// Nodes and edges as a g2o file holds them. A planar graph has z, roll and pitch zero.
struct PoseGraph {
  bool planar = false;
  std::vector<PoseNode> nodes;
  std::vector<PoseEdge> edges;
};

}  // namespace lidar_mapping::pose_graph
