// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

/// The trajectories of the key frames.
struct KeyFrameTrajectories {
  Trajectory laser_odom;  ///< T_odom_base
  Trajectory optimized;   ///< T_map_base of the newest revision
  Trajectory gnss;        ///< T_map_base as GNSS gives it, where it does
};

/// `poses` are those to take as optimised. `gnss` gives the position; the orientation is that which
/// came with it, or else the optimised one.
KeyFrameTrajectories key_frame_trajectories(const Session& session, const KeyFramePoses& poses,
                                            const std::vector<GnssPosition>& gnss);

/// Writes laser_odom, optimized and, where there is GNSS, ground_truth and gnss (the same twice:
/// the articles' name and the honest one) to `directory`. The .tum files hold all key frames that
/// have such a pose; the .txt files (KITTI, without stamps, compared line by line) hold the key
/// frames that are in all of them. laser_odom_scans.tum has every scan. Throws FileError.
void write_trajectories(const Session& session, const KeyFramePoses& poses,
                        const std::vector<GnssPosition>& gnss,
                        const std::filesystem::path& directory);

}  // namespace lidar_mapping::session
