// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// One of the drives of which a session was merged.
struct SessionDrive {
  std::vector<session::ScanOdometry> odometry;  ///< by stamp
  std::vector<KeyFrame> key_frames;             ///< by index
};

/// The drives of a session in the order in which they begin; they may overlap in time. A segment is
/// of the drive that its scans are of. One without odometry, as of a map that was imported, is a
/// drive of its own. Throws FileError.
std::vector<SessionDrive> drives_of(const session::Session& session);

}  // namespace lidar_mapping::pipeline
