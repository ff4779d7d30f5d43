// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::pose_graph {

/// Reads a graph from a binary file. Throws FileError if it is no such file, of another version,
/// cut or changed, or if it holds numbers that no graph has.
PoseGraph read_binary_graph(const std::string& path);
/// Writes a graph as a binary file, from which the same bits are read again (of a planar graph: x,
/// y and yaw). The format is described in doc/back_end.md. The file appears only when it is
/// complete. Throws FileError.
void write_binary_graph(const PoseGraph& graph, const std::string& path);

/// Reads a binary file if the name ends in .lmg, and g2o's text otherwise. Throws FileError.
G2oFile read_graph(const std::string& path);
/// Writes a binary file if the name ends in .lmg, and g2o's text otherwise. Throws FileError.
void write_graph(const PoseGraph& graph, const std::string& path);

}  // namespace lidar_mapping::pose_graph
