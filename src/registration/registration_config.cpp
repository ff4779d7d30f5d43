// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/registration_config.hpp"

#include <utility>
#include <vector>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::registration {

const std::vector<std::pair<std::string, Method>>& method_names() {
  static const std::vector<std::pair<std::string, Method>> names = {
      {"NDT", Method::kNdt},
      {"VGICP", Method::kVgicp},
      {"PCL_NDT", Method::kPclNdt},
      {"ICP", Method::kIcp},
      {"GICP", Method::kGicp},
      {"NDT_OMP", Method::kNdtOmp},
      {"FAST_GICP", Method::kFastGicp},
      {"FAST_VGICP", Method::kFastVgicp},
      {"GICP_OMP", Method::kGicpOmp}};
  return names;
}

namespace {

/// All but the method and what the fitness counts.
void describe_parameters(config::Schema<RegistrationConfig>& schema) {
  using C = RegistrationConfig;
  schema
      .real("reg_resolution", &C::resolution, {0.05, 50.0}, "m",
            "Edge of a voxel of the target's normal distributions.")
      .real("reg_step_size", &C::step_size, {1e-3, 10.0}, "m",
            "Longest step of the line search of PCL_NDT.")
      .real("reg_transformation_epsilon", &C::transformation_epsilon, {1e-6, 1.0}, "m",
            "A step that is shorter ends the search.")
      .real("reg_rotation_epsilon", &C::rotation_epsilon, {1e-6, kPi}, "rad",
            "A step that turns less, and is short, ends the search; pi looks at lengths alone.")
      .integer("reg_maximum_iterations", &C::max_iterations, {1, 10000}, "iterations",
               "Iterations after which a search has failed.")
      .real("reg_max_correspondence_distance", &C::max_correspondence_distance, {0.01, 100.0}, "m",
            "Points farther apart are no pair for ICP and GICP.")
      .integer("reg_correspondence_randomness", &C::correspondence_randomness, {5, 1000}, "points",
               "Neighbours from which GICP and VGICP take a point's covariance.")
      .integer("reg_max_optimizer_iterations", &C::max_optimizer_iterations, {1, 1000},
               "iterations", "Inner iterations of GICP.")
      .choice("neighbor_search", &C::neighbor_search,
              {{"DIRECT1", NeighborSearch::kDirect1},
               {"DIRECT7", NeighborSearch::kDirect7},
               {"KDTREE", NeighborSearch::kKdTree}},
              "Voxels in which NDT and VGICP look for a point's partners.")
      .integer("reg_num_threads", &C::num_threads, {0, 256}, "",
               "Upper limit of VGICP's threads; 0 takes all cores. The result does not depend on "
               "it.")
      .boolean("reg_use_reciprocal_correspondences", &C::use_reciprocal_correspondences,
               "ICP pairs only points that are each other's nearest.")
      .alias("reg_nn_search_method", "neighbor_search")
      .alias("NDT/res", "reg_resolution")
      .alias("NDT/step_size", "reg_step_size")
      .alias("NDT/trans_eps", "reg_transformation_epsilon")
      .alias("NDT/max_iter", "reg_maximum_iterations");
}

}  // namespace

const config::Schema<RegistrationConfig>& RegistrationConfig::schema() {
  using C = RegistrationConfig;
  static const auto schema = [] {
    config::Schema<C> result("registration", "Scan matching: registration of two point clouds");
    result.choice("registration_method", &C::method, method_names(),
                  "Method that aligns clouds; hdl_graph_slam's names stand for ours.");
    describe_parameters(result);
    result.real("fitness_score_max_range", &C::fitness_max_range, {0.01, 100.0}, "m",
                "Points farther from the target count neither in the fitness nor in the overlap.");
    return result;
  }();
  return schema;
}

const config::Schema<RegistrationConfig>& RegistrationConfig::parameters() {
  static const auto schema = [] {
    config::Schema<RegistrationConfig> result("registration", "Parameters of the methods");
    describe_parameters(result);
    return result;
  }();
  return schema;
}

Method implemented_by(Method method) {
  switch (method) {
    case Method::kNdtOmp:
      return Method::kNdt;
    case Method::kFastGicp:
    case Method::kFastVgicp:
      return Method::kVgicp;
    case Method::kGicpOmp:
      return Method::kGicp;
    default:
      return method;
  }
}

std::string describe_substitution(const RegistrationConfig& config) {
  const Method used = implemented_by(config.method);
  if (used == config.method) return "";
  return "registration_method " + to_string(config.method) + " is hdl_graph_slam's; " +
         to_string(used) + " does its work here";
}

std::string to_string(Method method) {
  for (const auto& [name, value] : method_names()) {
    if (value == method) return name;
  }
  return "";
}

}  // namespace lidar_mapping::registration
