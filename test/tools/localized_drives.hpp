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

/// The map of a part of the figure eight, made by an OS1-64, and other drives through it: of
/// another day, with other cars, in the other direction, by another sensor.
class LocalizedDrives : public testing::Test {
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
  static std::string bag(const std::string& name, Words words) {
    const std::filesystem::path path = root() / (name + ".bag");
    if (std::filesystem::exists(path)) return path;
    words.insert(words.begin(), {path.string(), "--drive", "figure_eight", "--truth",
                                 (root() / (name + ".tum")).string()});
    EXPECT_EQ(run("simulate_drive", words), 0) << said();
    return path;
  }
  static std::string map() {
    const std::filesystem::path session = root() / "map";
    if (std::filesystem::exists(session)) return session;
    const std::string drive = bag("mapping", {"--lidar", "os1_64", "--duration", "45"});
    EXPECT_EQ(run("map_bag", {drive, "-o", session, "--no-map"}), 0) << said();
    return session;
  }
  static std::string other_day() {
    return bag("other_day", {"--lidar", "vlp16", "--pass", "1", "--parked", "1", "--start", "6",
                             "--duration", "32"});
  }
  static std::string way_back() {
    return bag("way_back", {"--lidar", "os1_64", "--pass", "2", "--parked", "2", "--reverse",
                            "--start", "24", "--duration", "50"});
  }
  static int localize(const std::string& drive, const std::filesystem::path& output,
                      Words more = {}) {
    more.insert(more.begin(), {drive, map(), "-o", output.string()});
    return run("localize_bag", more);
  }

  /// The drive of another day in the map, localised once.
  static std::filesystem::path localized_day() {
    const std::filesystem::path output = root() / "day";
    if (std::filesystem::exists(output)) return output;
    EXPECT_EQ(localize(other_day(), output), 0) << said();
    EXPECT_TRUE(has_said("found after")) << said();
    return output;
  }

  /// T_truth_map: where the map lies in the simulated world. The mapping drive's own errors of some
  /// millimetres stay in the errors of a drive that is localised.
  static Pose T_truth_map() {
    return evaluation::rigid_alignment(evaluation::associate(
        read_trajectory(root() / "mapping.tum"),
        read_trajectory(std::filesystem::path(map()) / "trajectory/optimized.tum")));
  }
  /// Errors of a localised drive against the truth of its bag.
  static evaluation::PoseErrors errors_of(const std::string& name,
                                          const std::filesystem::path& output) {
    const auto pairs = evaluation::associate(read_trajectory(root() / (name + ".tum")),
                                             read_trajectory(output / "trajectory/localized.tum"));
    const auto errors = evaluation::absolute_pose_error(evaluation::aligned(pairs, T_truth_map()));
    std::printf("%s: %zu poses, %.3f m rms, %.3f m at most, %.3f degrees rms, %.3f at most\n",
                name.c_str(), pairs.size(), errors.translation_m.rmse, errors.translation_m.max,
                errors.rotation_deg.rmse, errors.rotation_deg.max);
    return errors;
  }
};

}  // namespace lidar_mapping::test
