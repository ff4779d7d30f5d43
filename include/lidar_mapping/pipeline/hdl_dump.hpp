// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Writes a session in the format in which hdl_graph_slam dumps its state and which
/// interactive_slam opens (doc/session.md): graph.g2o with an anchor, 000000/{data,cloud.pcd} for
/// each key frame, special_nodes.csv and, with a datum, zero_utm. The folder must not exist; it
/// appears completely or not at all. The ids of `graph` are the indices of the key frames; `in_enu`
/// says whether its poses lie in East-North-Up (BackEnd::in_enu()). Throws FileError.
void write_hdl_dump(const session::Session& session, const pose_graph::PoseGraph& graph,
                    bool in_enu, const std::filesystem::path& directory);

/// What was read from a dump.
struct HdlImport {
  std::size_t key_frames = 0;  ///< Number of key frames.
  std::size_t loops = 0;       ///< Number of loops.
  /// Number of segments: runs of key frames that consecutive edges connect.
  std::size_t segments = 0;
};

/// Reads such a folder into a new session. Edges between consecutive key frames become odometry,
/// all others become loops; floors, IMU samples and GNSS positions are added where they exist.
/// Vertices and edges of other kinds are left out. Throws FileError if something is missing or
/// damaged; the session is then incomplete.
HdlImport read_hdl_dump(const std::filesystem::path& directory, session::Session& session);

}  // namespace lidar_mapping::pipeline
