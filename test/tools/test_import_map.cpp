// SPDX-License-Identifier: BSD-3-Clause
// From a map in tiles, or in one file, back to a session in which other drives are found.
#include <filesystem>

#include <gtest/gtest.h>

#include "localized_drives.hpp"
#include "near.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::near;
using test::Words;

class ImportMap : public test::LocalizedDrives {
 protected:
  /// Tiles and one file of the map, as another tool could have made them.
  static const fs::path& made() {
    static const fs::path folder = [] {
      fs::path path = root() / "made";
      const Words words = {map(), "-o", path, "--formats", "tiles,pcd"};
      EXPECT_EQ(run("build_map", words), 0);
      return path;
    }();
    return folder;
  }
  static std::string imported(const std::string& name, const Words& words) {
    const fs::path session = root() / name;
    EXPECT_EQ(run("import_map", joined(words, {"-o", session})), 0);
    return session;
  }
};

TEST_F(ImportMap, OfTilesIsOneInWhichAnotherDriveFindsItself) {
  const std::string session =
      imported("imported_tiles", {made() / "pointcloud_map", "--spacing", "7"});
  EXPECT_TRUE(has_said("ground: "));
  const fs::path output = root() / "day_in_tiles";
  ASSERT_EQ(localize_in(session, other_day(), output), 0);
  const auto errors = errors_of("other_day", output);
  EXPECT_GT(errors.translation_m.count, 200U);
  EXPECT_LT(errors.translation_m.max, 0.3);
  EXPECT_LT(errors.translation_m.rmse, 0.05);
  EXPECT_LT(errors.rotation_deg.max, 1.0);
}

TEST_F(ImportMap, AlongATrajectoryIsASessionForTheOtherCommands) {
  const std::string session = imported(
      "imported_drive", {made() / "map.pcd", "--trajectory", map() + "/trajectory/optimized.tum"});
  EXPECT_TRUE(has_said("datum: ")) << "which map.yaml has";
  EXPECT_TRUE(test::holds(content_of(fs::path(session) / "run.json"), "map.pcd"));

  const fs::path output = root() / "day_on_trajectory";
  ASSERT_EQ(localize_in(session, other_day(), output, {"--duration", "6"}), 0);
  EXPECT_LT(errors_of("other_day", output).translation_m.max, 0.3);

  const fs::path solved = root() / "solved";
  ASSERT_EQ(run("optimize_session", {session, "--output", solved}), 0);
  const auto before = read_trajectory(session + "/trajectory/optimized.tum").poses;
  const auto after = read_trajectory(solved / "trajectory/optimized.tum").poses;
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(near(after[i].pose.translation, before[i].pose.translation, 1e-3)) << i;
  }
  EXPECT_EQ(run("map_quality", {session}), 0);
}

}  // namespace
}  // namespace lidar_mapping::tools
