// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// A graph as a file gave it, and what had to be mended: a line each.
struct G2oFile {
  PoseGraph graph;
  std::vector<std::string> notes;
};

/// Reads VERTEX_SE3:QUAT and EDGE_SE3:QUAT, or VERTEX_SE2 and EDGE_SE2. Nodes come ordered by id.
/// Vertices that only edges name are placed along the edges. An information matrix that is not
/// positive definite loses its translation-rotation block; if that does not mend it the file is
/// refused. Throws FileError with the line for whatever cannot be understood.
G2oFile read_g2o(const std::string& path);
G2oFile read_g2o(std::istream& stream, const std::string& name);

/// Writes with 17 significant digits, so that reading gives the same bits. To a file: written aside
/// and renamed. Throws FileError.
void write_g2o(const PoseGraph& graph, const std::string& path);
void write_g2o(const PoseGraph& graph, std::ostream& stream);

}  // namespace lidar_mapping::pose_graph
