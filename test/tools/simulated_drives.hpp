// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "file_content.hpp"
#include "program.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// Simulated drives, and what the commands make of them, in one folder for all tests of a program.
/// The map is that of the drive "mapping".
class SimulatedDrives : public testing::Test {
 protected:
  static const std::filesystem::path& root() {
    static const TemporaryFolder folder;
    return folder.path();
  }
  static int run(const std::string& program, const Words& words) {
    return Program(program, words, root() / "log").wait();
  }
  static std::string said() { return content_of(root() / "log"); }
  static bool has_said(const std::string& words) { return said().find(words) != std::string::npos; }

  /// Simulates a drive once; its truth lies beside it.
  static std::string simulated(const std::string& name, Words words) {
    const std::filesystem::path path = root() / (name + ".bag");
    if (std::filesystem::exists(path)) return path;
    words.insert(words.begin(), {path.string(), "--truth", (root() / (name + ".tum")).string()});
    EXPECT_EQ(run("simulate_drive", words), 0) << said();
    return path;
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
