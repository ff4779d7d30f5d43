#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

#include "config_documents.hpp"

namespace lidar_mapping::tools {
namespace {

/// Tests run in the folder test/.
std::string shipped_path(const std::string& stage) { return "../config/" + stage + ".yaml"; }

std::string shipped(const std::string& stage) {
  std::ifstream file(shipped_path(stage), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ConfigDocuments, ShippedFilesAreThoseOfTheSchemas) {
  for (const ConfigDocument& document : config_documents()) {
    EXPECT_EQ(shipped(document.stage), document.yaml)
        << "write them again: rosrun lidar_mapping describe_config --write config";
  }
}

TEST(ConfigDocuments, ManualHasTheTablesOfTheSchemas) {
  std::ifstream file("../doc/parameters.md", std::ios::binary);
  const std::string manual{std::istreambuf_iterator<char>(file), {}};
  for (const ConfigDocument& document : config_documents()) {
    EXPECT_NE(manual.find(document.markdown), std::string::npos)
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

TEST(ConfigDocuments, EveryFieldSaysWhatItMeans) {
  for (const auto& field : config::descriptions<front_end::FrontEndConfig>()) {
    EXPECT_FALSE(field.meaning.empty()) << field.name;
  }
}

}  // namespace
}  // namespace lidar_mapping::tools
