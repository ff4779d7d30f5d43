// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "commands.hpp"

namespace lidar_mapping::test {

/// Simulated drives, and what the commands make of them. The map is that of the drive "mapping".
class SimulatedDrives : public Commands {
 protected:
  /// Simulates a drive once; its truth lies beside it.
  static std::string simulated(const std::string& name, const Words& words) {
    const std::filesystem::path path = root() / (name + ".bag");
    if (std::filesystem::exists(path)) return path;
    const Words outputs = {path, "--truth", root() / (name + ".tum")};
    EXPECT_EQ(run("simulate_drive", joined(outputs, words)), 0);
    return path;
  }

  static Ending localize_in(const std::filesystem::path& map, const std::string& drive,
                            const std::filesystem::path& output, const Words& more = {}) {
    return run("localize_bag", joined({drive, map, "-o", output}, more));
  }

  /// T_truth_map: where the map lies in the simulated world, by the session `map`. The mapping
  /// drive's own errors of some millimetres stay in the errors of a drive that is localised.
  static Pose T_truth_map(const std::filesystem::path& map) {
    return evaluation::rigid_alignment(
        evaluation::associate(read_trajectory(root() / "mapping.tum"),
                              read_trajectory(map / "trajectory/optimized.tum")));
  }
  /// Errors of poses in the map against the truth of a bag.
  static evaluation::PoseErrors errors_of(const std::string& name, const Trajectory& poses,
                                          const Pose& T_world_map) {
    const auto pairs = evaluation::associate(read_trajectory(root() / (name + ".tum")), poses);
    const auto errors = evaluation::absolute_pose_error(evaluation::aligned(pairs, T_world_map));
    std::printf("%s: %zu poses, %.3f m rms, %.3f m at most, %.3f degrees rms, %.3f at most\n",
                name.c_str(), pairs.size(), errors.translation_m.rmse, errors.translation_m.max,
                errors.rotation_deg.rmse, errors.rotation_deg.max);
    return errors;
  }
};

}  // namespace lidar_mapping::test
