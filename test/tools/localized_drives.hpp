// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "simulated_drives.hpp"

namespace lidar_mapping::test {

/// The map of a part of the figure eight, made by an OS1-64, and other drives through it: of
/// another day, with other cars, in the other direction, by another sensor.
class LocalizedDrives : public SimulatedDrives {
 protected:
  static std::string bag(const std::string& name, const Words& words) {
    return simulated(name, joined({"--drive", "figure_eight"}, words));
  }
  static std::string map() {
    const std::filesystem::path session = root() / "map";
    if (std::filesystem::exists(session)) return session;
    const std::string drive = bag("mapping", {"--lidar", "os1_64", "--duration", "45"});
    EXPECT_EQ(run("map_bag", {drive, "-o", session, "--no-map"}), 0);
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
  static Ending localize(const std::string& drive, const std::filesystem::path& output,
                         const Words& more = {}) {
    return localize_in(map(), drive, output, more);
  }

  /// The drive of another day in the map, localised once.
  static std::filesystem::path localized_day() {
    const std::filesystem::path output = root() / "day";
    if (std::filesystem::exists(output)) return output;
    EXPECT_EQ(localize(other_day(), output), 0);
    EXPECT_TRUE(has_said("found after"));
    return output;
  }

  static Pose T_truth_map() { return SimulatedDrives::T_truth_map(map()); }
  /// Errors of a localised drive against the truth of its bag.
  static evaluation::PoseErrors errors_of(const std::string& name,
                                          const std::filesystem::path& output) {
    return SimulatedDrives::errors_of(name, read_trajectory(output / "trajectory/localized.tum"),
                                      T_truth_map());
  }
};

}  // namespace lidar_mapping::test
