// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// The content of a g2o file (Kuemmerle et al. 2011).
struct G2oFile {
  PoseGraph graph;                 ///< nodes ordered by id, edges in the order of the file
  std::vector<std::string> notes;  ///< what was repaired or ignored, one sentence each
};

/// Reads the lines VERTEX_SE3:QUAT and EDGE_SE3:QUAT, or VERTEX_SE2 and EDGE_SE2. A vertex that
/// appears only in edges gets its pose from the edges. If an information matrix is not positive
/// definite, its translation-rotation block is set to zero. Throws FileError with the number of the
/// line for everything that cannot be read, also if the information is still not positive definite.
G2oFile read_g2o(const std::string& path);
/// Reads from a stream; `name` stands for the file in messages.
G2oFile read_g2o(std::istream& stream, const std::string& name);

/// Writes a graph to a file with as many digits as it takes for the same bits to be read again. The
/// file appears only when it is complete. Throws FileError.
void write_g2o(const PoseGraph& graph, const std::string& path);
/// Writes a graph to a stream in the same format.
void write_g2o(const PoseGraph& graph, std::ostream& stream);

}  // namespace lidar_mapping::pose_graph
