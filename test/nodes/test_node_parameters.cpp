// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/parameters.hpp"

#include "back_end_node_config.hpp"
#include "map_viewer_node_config.hpp"
#include "parameters/stage_files.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

/// One file serves a node and map_bag, so the commands accept all that the node accepts.
template <typename Config>
void expect_commands_accept() {
  const config::Schema<Config>& schema = Config::schema();
  std::map<std::string, std::string> defaults;
  for (const auto& field : schema.fields()) {
    defaults[field.description.name] = field.description.default_value;
  }
  std::map<std::string, std::string> accepted = defaults;
  for (const auto& [alias, name] : schema.aliases()) accepted[alias] = defaults.at(name);
  for (const auto& [name, value] : accepted) {
    const std::string parameter = schema.stage() + "/" + name + ": " + value;
    EXPECT_NO_THROW(tools::read_stage_files({"", "", "", {parameter}})) << parameter;
  }
}

TEST(NodeParameters, AreAcceptedByTheCommands) {
  expect_commands_accept<NodeConfig<preprocessing::PreprocessingConfig>>();
  expect_commands_accept<NodeConfig<preprocessing::FloorDetectionConfig>>();
  expect_commands_accept<LidarNodeConfig<front_end::FrontEndConfig>>();
  expect_commands_accept<LidarNodeConfig<loop_closing::LoopClosingConfig>>();
  expect_commands_accept<BackEndNodeConfig>();
  expect_commands_accept<MapViewerNodeConfig>();
}

TEST(Overlays, HaveTheSameGroupsForNodesAndCommands) {
  std::vector<std::string> groups{"nodes"};
  for (const auto& [stage, text] : tools::read_stage_files({}).texts) groups.push_back(stage);
  EXPECT_EQ(overlay_groups(), groups);
}

/// A copy of the shipped files with values for a sensor, as the manual advises.
TEST(Overlays, ThatReplaceAValueOfTheUserAreNamedWithBothOrigins) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "preprocessing.yaml")
      << "scan_stamp: START\nscan_period: 0.05\ndistance_near_thresh: 0.3\n";
  const std::string file = folder.path() / "preprocessing.yaml";
  const std::string overlay = folder.path() / "mine.yaml";
  std::ofstream(overlay) << "preprocessing: {scan_stamp: MIDDLE, scan_period: 0.1, "
                            "distance_near_thresh: 0.3}\n";
  const tools::StageFiles files =
      tools::read_stage_files({folder.path(), overlay, "", {"preprocessing/scan_stamp: END"}});
  EXPECT_EQ(files.replaced,
            std::vector<std::string>{"preprocessing/scan_period: 0.1 of " + overlay +
                                     " is in force, not 0.05 of " + file});
  EXPECT_EQ(
      tools::read_stage_files({folder.path(), "vlp16", "", {}}).pipeline.preprocessing.scan_period,
      0.05)
      << "an overlay of the package has only what differs from the defaults";
}

}  // namespace
}  // namespace lidar_mapping::ros_border
