// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

/// Trajectories of the key frames, ordered by stamp.
struct KeyFrameTrajectories {
  Trajectory laser_odom;  ///< T_odom_base by odometry
  Trajectory optimized;   ///< T_map_base after optimisation
  Trajectory gnss;        ///< T_map_base by GNSS, for key frames with a position
};

/// Collects the trajectories. `poses` are the optimised poses. A pose by GNSS has the position of
/// `gnss` and the orientation that was measured with it, otherwise the optimised orientation.
KeyFrameTrajectories key_frame_trajectories(const Session& session, const KeyFramePoses& poses,
                                            const std::vector<GnssPosition>& gnss);

/// Writes the files laser_odom, optimized, ground_truth and gnss to `directory`, the last two only
/// with GNSS. Both have the same content: ground_truth is the name that the lidar_localization
/// project uses. The .tum files hold all key frames with such a pose. The .txt files (KITTI,
/// without stamps, compared line by line) hold only the key frames that all files have in common.
/// laser_odom_scans.tum holds all scans. Throws FileError.
void write_trajectories(const Session& session, const KeyFramePoses& poses,
                        const std::vector<GnssPosition>& gnss,
                        const std::filesystem::path& directory);

}  // namespace lidar_mapping::session
