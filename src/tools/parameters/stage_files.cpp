// SPDX-License-Identifier: BSD-3-Clause
#include "parameters/stage_files.hpp"

#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/config/overlay.hpp"

#include "parameters/config_path.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;

/// Parameters that only the nodes have, and which a command accepts without effect. The schemas of
/// the nodes need ROS, so a test (test_node_parameters.cpp) holds this list against them.
const std::set<std::string> kNodeFields = {
    "map_frame", "odom_frame", "queue_size",  "session_directory",
    "data_path", "resume",     "lidar_frame", "map_cloud_update_interval"};

/// A folder in config/ of the package: installed with this program, or in the source tree.
fs::path config_folder(const std::string& name) {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path installed = programs / "../../share/lidar_mapping/config" / name;
  return fs::is_directory(installed) ? installed.lexically_normal()
                                     : fs::path(LIDAR_MAPPING_CONFIG) / name;
}

std::string names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (entry.path().extension() == ".yaml") names.insert(entry.path().stem());
  }
  return joined({names.begin(), names.end()});
}

/// `kind` is sensor or preset.
std::string overlay_file(const std::string& kind, const std::string& name_or_path) {
  const bool is_path = name_or_path.find('/') != std::string::npos;
  if (is_path || fs::exists(name_or_path)) return name_or_path;
  const fs::path folder = config_folder(kind + "s");
  const fs::path file = folder / (name_or_path + ".yaml");
  if (fs::exists(file)) return file;
  throw ConfigError("no " + kind + " " + name_or_path + " in " + folder.string() + "; there are " +
                    names_in(folder) + "; or name a file");
}

class StageReader {
 public:
  explicit StageReader(const ParameterSources& sources) : config_(sources.config) {
    add_overlay("sensor", sources.overlay);
    add_overlay("preset", sources.preset);
    for (const std::string& parameter : sources.parameters) add_parameter(parameter);
    for (config::Source& nodes : overlay_parts("nodes")) remove_node_fields(nodes);
  }

  template <typename Config>
  Config read() {
    const std::string& stage = Config::schema().stage();
    std::vector<config::Source> sources;
    const std::string file = stage_file(config_, stage);
    if (!file.empty()) {
      sources.push_back(config::read_yaml_file(file));
      found_file_ = true;
    }
    for (const config::Source& part : overlay_parts(stage)) sources.push_back(part);
    for (const std::string& line : config::replaced_values<Config>(sources)) {
      result.replaced.push_back(stage + "/" + line);
    }
    for (const auto& [name, source] : parameters_) {
      if (name == stage) sources.push_back(source);
    }
    for (config::Source& source : sources) remove_node_fields(source);
    const Config config = config::load<Config>(sources);
    result.texts[stage] = config::to_yaml(config);
    return config;
  }

  /// Throws if a given parameter had no effect. It is called when all stages are read.
  void finish() {
    std::vector<std::string> names;
    for (const auto& [stage, text] : result.texts) names.push_back(stage);
    const std::string stages = joined(names);
    names.insert(names.begin(), "nodes");
    for (const config::Source& overlay : overlays_) config::check_groups(overlay, names);
    if (!config_.empty() && !found_file_) {
      throw FileError("there is no <stage>.yaml in " + config_ + "; the stages are " + stages);
    }
    for (const auto& [stage, source] : parameters_) {
      if (result.texts.count(stage) > 0) continue;
      throw ConfigError("--parameter: no stage has the name '" + stage + "'; the stages are " +
                        stages);
    }
  }

  StageFiles result;

 private:
  void add_overlay(const std::string& kind, const std::string& name_or_path) {
    if (name_or_path.empty()) return;
    overlays_.push_back(config::read_yaml_file(overlay_file(kind, name_or_path)));
  }

  /// "stage/name: value"
  void add_parameter(const std::string& text) {
    const config::Source source = config::parse_yaml(text, "--parameter '" + text + "'");
    for (const auto& [name, value] : config::flattened(source.values)) {
      const std::size_t slash = name.find('/');
      if (slash == std::string::npos) {
        throw ConfigError(source.origin + ": it is not of the form 'stage/name: value', as in " +
                          "'back_end/use_gnss: false'");
      }
      const config::Value::Map field = {{name.substr(slash + 1), value}};
      parameters_.push_back({name.substr(0, slash), {source.origin, {field}}});
    }
  }

  /// Parameters of a stage in the overlays; later ones have priority over earlier ones.
  std::vector<config::Source> overlay_parts(const std::string& stage) const {
    std::vector<config::Source> found;
    for (const config::Source& overlay : overlays_) {
      if (auto part = config::part_of(overlay, stage)) found.push_back(std::move(*part));
    }
    return found;
  }

  void remove_node_fields(config::Source& source) {
    auto* values = std::get_if<config::Value::Map>(&source.values.data);
    if (values == nullptr) return;
    for (const std::string& name : kNodeFields) values->erase(name);
    const auto base = values->find("base_frame");
    if (base == values->end()) return;
    result.base_frame = config::to_string(base->second);
    values->erase(base);
  }

  std::string config_;
  std::vector<config::Source> overlays_;
  std::vector<std::pair<std::string, config::Source>> parameters_;  ///< with their stage
  bool found_file_ = false;
};

}  // namespace

StageFiles read_stage_files(const ParameterSources& sources) {
  StageReader reader(sources);
  pipeline::PipelineConfig config;
  config.preprocessing = reader.read<preprocessing::PreprocessingConfig>();
  config.floor_detection = reader.read<preprocessing::FloorDetectionConfig>();
  config.front_end = reader.read<front_end::FrontEndConfig>();
  config.loop_closing = reader.read<loop_closing::LoopClosingConfig>();
  config.back_end = reader.read<back_end::BackEndConfig>();
  reader.result.map = reader.read<map::MapConfig>();
  reader.finish();
  reader.result.pipeline = config;
  return reader.result;
}

}  // namespace lidar_mapping::tools
