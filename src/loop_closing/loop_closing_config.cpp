// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

#include "lidar_mapping/loop_closing/method_substitution.hpp"

namespace lidar_mapping::loop_closing {

namespace {

using Config = LoopClosingConfig;

void describe_search(config::Schema<Config>& schema) {
  schema
      .integer("loop_step", &Config::loop_step, {1, 1000}, "key frames",
               "Search at most every so many key frames.")
      .real(
          "min_edge_interval", &Config::min_edge_interval, {-1.0, 1e4}, "m",
          "Distance to travel after an accepted loop before the next search; below 0 by the range "
          "of sight.")
      .boolean("position_candidates", &Config::position_candidates,
               "Candidates from the newest estimate of the trajectory.")
      .boolean("gnss_candidates", &Config::gnss_candidates, "Candidates from GNSS positions.")
      .boolean("appearance_candidates", &Config::appearance_candidates,
               "Candidates from the appearance of the surroundings from above.")
      .integer("diff_num", &Config::diff_num, {0, 100000}, "key frames",
               "Least gap between the indices of two key frames of a loop.")
      .real("accum_distance_thresh", &Config::accum_distance_thresh, {-1.0, 1e5}, "m",
            "Least distance travelled between two key frames of a loop; below 0 by the range of "
            "sight.")
      .real("detect_area", &Config::detect_area, {0.1, 100.0}, "m",
            "Radius of the search where positions are certain; it grows with the uncertainty.")
      .real("distance_thresh", &Config::distance_thresh, {0.1, 1e5}, "m",
            "Limit of the radius of the search, however uncertain the positions are.")
      .real("horizontal_drift", &Config::horizontal_drift, {0.0, 0.2}, "m/m",
            "Standard deviation of the estimate's horizontal drift per distance travelled.")
      .real("vertical_drift", &Config::vertical_drift, {0.0, 0.2}, "m/m",
            "Standard deviation of the height after 1 km; it grows with the power 1.5 of the "
            "distance.")
      .angle("rotation_drift_deg", &Config::rotation_drift, {0.0, 90.0}, "deg per 100 m",
             "Standard deviation of the estimate's rotation drift per distance travelled.")
      .integer("max_registrations", &Config::max_registrations, {1, 50}, "",
               "How many of the best candidates of one search are matched at most; if the estimate "
               "is certain to about a metre, the first accepted one ends the search.");
}

std::vector<std::pair<std::string, LoopMethod>> methods() {
  std::vector<std::pair<std::string, LoopMethod>> result = {{"POINT_TO_PLANE", {}}};
  for (const auto& [name, method] : registration::method_names()) {
    LoopMethod other;
    other.point_to_plane = false;
    other.other = method;
    result.emplace_back(name, other);
  }
  return result;
}

void describe_matching(config::Schema<Config>& schema) {
  const std::vector<std::pair<std::string, FilterMethod>> filters = {
      {"voxel_filter", FilterMethod::kVoxel}, {"no_filter", FilterMethod::kNone}};
  schema
      .integer("extend_frame_num", &Config::extend_frame_num, {0, 20}, "key frames",
               "The submap of an old key frame reaches so many key frames to either side.")
      .choice("map_filter", &Config::map_filter, filters, "How the submap is thinned.")
      .choice("scan_filter", &Config::scan_filter, filters, "How the newest scan is thinned.")
      .real("voxel_filter/map/leaf_size", &Config::map_leaf_size, {0.05, 5.0}, "m",
            "Edge of the submap's voxels.")
      .real("voxel_filter/scan/leaf_size", &Config::scan_leaf_size, {0.05, 5.0}, "m",
            "Edge of the scan's voxels.")
      .choice("registration_method", &Config::registration_method, methods(),
              "How a scan is aligned with a submap: POINT_TO_PLANE is the package's own method for "
              "loops, from coarse to fine; the reg_ parameters are for the others.")
      .include(&Config::registration, registration::RegistrationConfig::parameters());
}

void describe_verification(config::Schema<Config>& schema) {
  schema
      .real("max_loop_distance", &Config::max_loop_distance, {-1.0, 100.0}, "m",
            "Key frames that are further apart have too little overlap for a loop; below 0 by the "
            "range of sight, and more overlap is asked of those that are not close.")
      .real("overlap_margin_limit", &Config::overlap_margin_limit, {-2.0, 1.0}, "",
            "The overlap above ground minus twice the free-space violation of a loop must be "
            "larger than this.")
      .real("eigenvalue_limit", &Config::eigenvalue_limit, {0.0, 0.5}, "",
            "The horizontal eigenvalue of a loop must be larger than this: walls determine it in "
            "all directions.")
      .integer("min_tested_points", &Config::min_tested_points, {1, 100000}, "points",
               "With fewer points above ground a candidate stays undecided.")
      .real("innovation_limit", &Config::innovation_limit, {1.0, 1e6}, "",
            "Largest squared distance from the estimate in units of its covariance.")
      .real("fitness_score_limit", &Config::fitness_score_limit, {0.0, 1e6}, "m^2",
            "Largest mean squared distance of paired points; 0 leaves this figure out.")
      .real("fitness_score_max_range", &Config::fitness_score_max_range, {0.1, 1e6}, "m",
            "Points without a partner within this range do not count in the fitness.")
      .real("unanchored_path_length", &Config::unanchored_path_length, {0.0, 1e5}, "m",
            "Two unconnected segments are connected once loops agree over such a path length.")
      .real("min_stddev_x", &Config::min_stddev_x, {1e-3, 10.0}, "m",
            "Lower limit of a loop's standard deviation in translation.")
      .real("min_stddev_q", &Config::min_stddev_q, {1e-4, 1.0}, "rad",
            "Lower limit of a loop's standard deviation in rotation.")
      .alias("fitness_score_thresh", "fitness_score_limit")
      .alias("unanchored_stretch", "unanchored_path_length");
}

}  // namespace

std::string describe_substitution(const LoopMethod& method) {
  if (method.point_to_plane) return "";
  registration::RegistrationConfig config;
  config.method = method.other;
  return registration::describe_substitution(config);
}

const config::Schema<LoopClosingConfig>& LoopClosingConfig::schema() {
  static const auto schema = [] {
    config::Schema<Config> result("loop_closing", "Finding and verifying loops");
    describe_search(result);
    describe_matching(result);
    describe_verification(result);
    return result;
  }();
  return schema;
}

}  // namespace lidar_mapping::loop_closing
