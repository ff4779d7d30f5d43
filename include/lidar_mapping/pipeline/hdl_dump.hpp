// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Writes a session as hdl_graph_slam dumps its state and interactive_slam opens it
/// (doc/session.md): graph.g2o with an anchor, 000000/{data,cloud.pcd} for each key frame,
/// special_nodes.csv and, with a datum, zero_utm. The folder must not exist; it appears whole or
/// not at all. `graph` has the key frames' indices as ids. Throws FileError.
void write_hdl_dump(const session::Session& session, const pose_graph::PoseGraph& graph,
                    const std::filesystem::path& directory);

/// What a dump gave.
struct HdlImport {
  std::size_t key_frames = 0;
  std::size_t loops = 0;
  std::size_t segments = 0;  ///< stretches that consecutive edges join
};

/// Reads such a folder into a new session: edges between consecutive key frames become odometry,
/// others loops; floors, IMU and GNSS come along where they are there. Vertices and edges of other
/// kinds are left out. Throws FileError where something is missing or damaged; the session is then
/// incomplete.
HdlImport read_hdl_dump(const std::filesystem::path& directory, session::Session& session);

}  // namespace lidar_mapping::pipeline
