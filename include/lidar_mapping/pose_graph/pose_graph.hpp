// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::pose_graph {

/// A measured relative pose between two nodes. The information belongs to g2o's error: translation
/// and vector part of the quaternion (Kuemmerle et al. 2011). In a planar graph only its rows and
/// columns 0, 1 and 5 are used, for x, y and the full angle.
struct PoseEdge {
  std::int64_t from = 0;                        ///< id of the first node
  std::int64_t to = 0;                          ///< id of the second node
  Pose T_from_to;                               ///< measured pose, m
  Matrix6d information = Matrix6d::Identity();  ///< translation (1/m^2) before rotation
};

/// A node of the graph.
struct PoseNode {
  std::int64_t id = 0;  ///< unique number, not necessarily without gaps
  Pose pose;            ///< current estimate in the frame of the graph, T_map_base
};

/// A pose graph as a g2o file holds it.
struct PoseGraph {
  bool planar = false;          ///< z, roll and pitch of all poses are zero
  std::vector<PoseNode> nodes;  ///< ordered by id
  std::vector<PoseEdge> edges;  ///< relative poses between the nodes
};

}  // namespace lidar_mapping::pose_graph
