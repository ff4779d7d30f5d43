// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/config/overlay.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "holds.hpp"
#include "parameters/config_documents.hpp"
#include "parameters/stage_files.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

using test::holds;

/// Tests run in the folder test/.
std::string shipped_path(const std::string& stage) { return "../config/" + stage + ".yaml"; }

std::string shipped(const std::string& stage) { return test::content_of(shipped_path(stage)); }

TEST(ConfigDocuments, ShippedFilesAreThoseOfTheSchemas) {
  for (const ConfigDocument& document : config_documents()) {
    EXPECT_EQ(shipped(document.stage), document.yaml)
        << "write them again: rosrun lidar_mapping describe_config --write config";
  }
}

TEST(ConfigDocuments, ManualHasTheTablesOfTheSchemas) {
  const std::string manual = test::content_of("../doc/parameters.md");
  for (const ConfigDocument& document : config_documents()) {
    EXPECT_TRUE(holds(manual, document.markdown))
        << "write the table again: rosrun lidar_mapping describe_config --markdown "
        << document.stage;
  }
}

template <typename Config>
void expect_loads_as_default() {
  const auto loaded = config::load_file<Config>(shipped_path(Config::schema().stage()));
  EXPECT_EQ(config::to_yaml(loaded), config::to_yaml(Config()));
}

TEST(ConfigDocuments, ShippedFilesLoadAsTheDefaults) {
  expect_loads_as_default<preprocessing::PreprocessingConfig>();
  expect_loads_as_default<preprocessing::FloorDetectionConfig>();
  expect_loads_as_default<front_end::FrontEndConfig>();
  expect_loads_as_default<loop_closing::LoopClosingConfig>();
  expect_loads_as_default<back_end::BackEndConfig>();
  expect_loads_as_default<map::MapConfig>();
}

/// The overlays in a folder of config/, by name.
std::vector<std::string> overlays_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator("../config/" + folder)) {
    names.push_back(entry.path().stem().string());
  }
  return names;
}

TEST(Overlays, OfThePackageAreReadWhole) {
  for (const std::string& sensor : overlays_in("sensors")) {
    EXPECT_NO_THROW(read_stage_files({"", sensor, "", {}})) << sensor;
  }
  for (const std::string& preset : overlays_in("presets")) {
    EXPECT_NO_THROW(read_stage_files({"", "", preset, {}})) << preset;
  }
}

/// The values of an overlay that are the defaults, of all stages.
template <typename... Stages>
std::vector<std::string> idle_values(const config::Source& overlay) {
  std::vector<std::string> idle;
  const auto add = [&](const auto& schema, auto config) {
    const auto part = config::part_of(overlay, schema.stage());
    if (!part) return;
    for (const auto& [key, value] : config::flattened(part->values)) {
      for (const auto& field : schema.fields()) {
        if (field.description.name != key || !field.read(config, value).empty()) continue;
        if (field.print(config) == field.description.default_value) idle.push_back(key);
      }
    }
  };
  (add(Stages::schema(), Stages()), ...);
  return idle;
}

// A value that is the default anyway took the place of the user's own in silence.
TEST(Overlays, OfThePackageHaveOnlyWhatDiffersFromTheDefaults) {
  for (const char* folder : {"sensors", "presets"}) {
    for (const std::string& name : overlays_in(folder)) {
      const std::string path = "../config/" + std::string(folder) + "/" + name + ".yaml";
      const std::vector<std::string> idle =
          idle_values<preprocessing::PreprocessingConfig, preprocessing::FloorDetectionConfig,
                      front_end::FrontEndConfig, loop_closing::LoopClosingConfig,
                      back_end::BackEndConfig, map::MapConfig>(config::read_yaml_file(path));
      EXPECT_TRUE(idle.empty()) << path << ": " << joined(idle);
    }
  }
}

TEST(Overlays, OfThePlaceGoOverThatOfTheSensorAndSingleParametersOverBoth) {
  const StageFiles outdoor = read_stage_files({"", "vlp16", "", {}});
  const StageFiles indoor = read_stage_files({"", "vlp16", "indoor", {}});
  EXPECT_EQ(indoor.pipeline.preprocessing.distance_near_thresh,
            outdoor.pipeline.preprocessing.distance_near_thresh);
  EXPECT_LT(indoor.pipeline.front_end.key_frame_distance,
            outdoor.pipeline.front_end.key_frame_distance);
  EXPECT_LT(indoor.map.resolution, outdoor.map.resolution);
  const StageFiles asked =
      read_stage_files({"", "vlp16", "indoor", {"front_end/key_frame_distance: 0.7"}});
  EXPECT_EQ(asked.pipeline.front_end.key_frame_distance, 0.7);
  const std::string problem = test::error_text<ConfigError>([] {
    read_stage_files({"", "", "outdoors", {}});
  });
  EXPECT_TRUE(holds(problem, "there are indoor"));
}

TEST(StageFiles, HaveAnglesInDegreesAndStagesInRadians) {
  const StageFiles files = read_stage_files(
      {"", "kitti", "", {"floor_detection/tilt_deg: 20", "loop_closing/rotation_drift_deg: 1.5"}});
  const pipeline::PipelineConfig& stages = files.pipeline;
  EXPECT_EQ(stages.preprocessing.vertical_angle_correction, 0.205 * kRadPerDeg);
  EXPECT_EQ(stages.floor_detection.tilt, 20.0 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(stages.loop_closing.rotation_drift, 0.015 * kRadPerDeg);
  const std::string& text = files.texts.at("preprocessing");
  EXPECT_TRUE(holds(text, "\nvertical_angle_correction_deg: 0.205\n"));
}

TEST(StageFiles, ReadsTheFileOfTheMapViewer) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "map.yaml")
      << "map_frame: map\nmap_cloud_update_interval: 5.0\nmap_cloud_resolution: 0.3\n";
  EXPECT_EQ(read_stage_files({folder.path(), "", "", {}}).map.resolution, 0.3);
}

TEST(ConfigDocuments, EveryFieldSaysWhatItMeans) {
  for (const auto& field : config::descriptions<front_end::FrontEndConfig>()) {
    EXPECT_FALSE(field.meaning.empty()) << field.name;
  }
}

}  // namespace
}  // namespace lidar_mapping::tools
