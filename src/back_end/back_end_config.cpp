// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/back_end/back_end_config.hpp"

#include <algorithm>
#include <cctype>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::back_end {

namespace {

using Config = BackEndConfig;

constexpr config::Range kStddev = {1e-6, 1e3};
constexpr config::Range kSteps = {1, 1e9};

/// The names of the kernels also in upper and in lower case, as configuration files of other
/// programs have them.
std::vector<std::pair<std::string, pose_graph::RobustKernel>> kernels_in_any_case() {
  std::vector<std::pair<std::string, pose_graph::RobustKernel>> choices =
      pose_graph::robust_kernel_names();
  for (const auto& [name, kernel] : pose_graph::robust_kernel_names()) {
    std::string capital = name;
    for (char& c : capital) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    choices.emplace_back(lower_case(name), kernel);
    choices.emplace_back(capital, kernel);
  }
  return choices;
}

void describe_use(config::Schema<Config>& schema) {
  schema.boolean("use_gnss", &Config::use_gnss, "Whether GNSS positions are used at all.")
      .boolean("georeference_only", &Config::georeference_only,
               "With use_gnss: GNSS only moves the whole map to East-North-Up, without bending it.")
      .boolean("use_loop_close", &Config::use_loop_close, "Whether loops are used.")
      .alias("enable_gps", "use_gnss");
}

void describe_triggers(config::Schema<Config>& schema) {
  schema
      .integer("optimize_step_with_key_frame", &Config::optimize_step_with_key_frame, kSteps,
               "key frames", "Optimise at the latest after so many new key frames.")
      .integer("optimize_step_with_gnss", &Config::optimize_step_with_gnss, kSteps, "positions",
               "Optimise at the latest after so many new GNSS positions.")
      .integer("optimize_step_with_loop", &Config::optimize_step_with_loop, kSteps, "loops",
               "Optimise after so many new loops.")
      .real("optimize_min_interval", &Config::optimize_min_interval, {0.0, 1e4}, "s",
            "Least time between optimisations, by the key frames' stamps.")
      .alias("graph_update_interval", "optimize_min_interval");
}

void describe_odometry(config::Schema<Config>& schema) {
  schema
      .real(
          "odometry_drift", &Config::odometry_drift, {0.0, 1.0}, "fraction of the distance",
          "Upper limit of the standard deviation that drift adds to a motion's translation. Where "
          "positions show less drift, this and the next three are reduced, but not below a tenth.")
      .angle("odometry_drift_deg_per_m", &Config::odometry_rotation_drift, {0.0, 10.0}, "deg/m",
             "Standard deviation that drift adds to a motion's rotation.")
      .real("odometry_min_stddev_m", &Config::odometry_min_stddev_m, kStddev, "m",
            "Added to the covariance of every motion.")
      .angle("odometry_min_stddev_deg", &Config::odometry_min_stddev_rad, kStddev, "deg",
             "Added to the covariance of every motion.")
      .real("odometry_degenerate_drift", &Config::odometry_degenerate_drift, {0.0, 10.0},
            "fraction of the distance",
            "Standard deviation added along directions that matching could not observe.");
}

void describe_loops(config::Schema<Config>& schema) {
  schema
      .real("loop_min_stddev_m", &Config::loop_min_stddev_m, kStddev, "m",
            "Added to the covariance of every loop.")
      .angle("loop_min_stddev_deg", &Config::loop_min_stddev_rad, kStddev, "deg",
             "Added to the covariance of every loop.");
}

void describe_first_node(config::Schema<Config>& schema) {
  schema
      .boolean("fix_first_node", &Config::fix_first_node,
               "Give the first key frame a prior with fix_first_node_stddev, instead of one that "
               "depends on the other constraints.")
      .reals("fix_first_node_stddev", &Config::fix_first_node_stddev, 6,
             "m and rad: x y z roll pitch yaw",
             "With fix_first_node: standard deviations of its pose, in the axes of base_link.");
}

/// As in hdl_graph_slam, in place of the covariances of motions and loops.
void describe_other_weights(config::Schema<Config>& schema) {
  schema
      .boolean("use_const_inf_matrix", &Config::use_const_inf_matrix,
               "Weight all motions and loops by const_stddev_x and const_stddev_q instead of their "
               "covariances.")
      .boolean("use_fitness_inf_matrix", &Config::use_fitness_inf_matrix,
               "Weight loops by their fitness (var_gain_a, min and max stddevs) instead of their "
               "covariances.")
      .real("const_stddev_x", &Config::const_stddev_x, kStddev, "m",
            "Standard deviation of the translation, with use_const_inf_matrix.")
      .real("const_stddev_q", &Config::const_stddev_q, kStddev, "half rad",
            "Standard deviation of the vector part of the quaternion, with use_const_inf_matrix.")
      .real("var_gain_a", &Config::var_gain_a, {1e-3, 1e3}, "1/m^2",
            "How fast variances grow with the fitness, with use_fitness_inf_matrix.")
      .real("min_stddev_x", &Config::min_stddev_x, kStddev, "m", "At fitness zero.")
      .real("max_stddev_x", &Config::max_stddev_x, kStddev, "m", "At inf_matrix_max_fitness.")
      .real("min_stddev_q", &Config::min_stddev_q, kStddev, "half rad", "At fitness zero.")
      .real("max_stddev_q", &Config::max_stddev_q, kStddev, "half rad",
            "At inf_matrix_max_fitness.")
      .real("inf_matrix_max_fitness", &Config::inf_matrix_max_fitness, {1e-6, 1e6}, "m^2",
            "Fitness at which the variances reach their maxima.");
}

void describe_gnss(config::Schema<Config>& schema) {
  schema
      .real("gnss_min_stddev_m", &Config::gnss_min_stddev_m, kStddev, "m",
            "Least horizontal standard deviation of a GNSS position.")
      .real("gnss_min_stddev_altitude_m", &Config::gnss_min_stddev_altitude_m, kStddev, "m",
            "Least standard deviation of a GNSS altitude.")
      .real("gnss_max_stddev_m", &Config::gnss_max_stddev_m, kStddev, "m",
            "Positions with a larger horizontal standard deviation are refused.")
      .real("gnss_correlation_distance", &Config::gnss_correlation_distance, {0.0, 1e4}, "m",
            "Fixes closer together have one error in common; their weights are reduced to that of "
            "one fix.")
      .real("gnss_alignment_distance", &Config::gnss_alignment_distance, {1.0, 1e5}, "m",
            "Least extent of the track before it is aligned to East-North-Up.")
      .angle("gnss_alignment_stddev_deg", &Config::gnss_alignment_stddev, {0.01, 10.0}, "deg",
             "Largest standard deviation of the heading with which the track is aligned to "
             "East-North-Up.")
      .boolean("estimate_gnss_time_offset", &Config::estimate_gnss_time_offset,
               "Correct GNSS stamps that are late or early relative to odometry.");
}

void describe_imu(config::Schema<Config>& schema) {
  schema
      .boolean("enable_imu_orientation", &Config::enable_imu_orientation,
               "Whether the tilt of the IMU's orientation keeps the map level.")
      .boolean("enable_imu_heading", &Config::enable_imu_heading,
               "Whether headings that come with GNSS positions are used; only for an IMU with a "
               "true heading.")
      .boolean("enable_imu_acceleration", &Config::enable_imu_acceleration,
               "Whether the measured acceleration, as gravity, keeps the map level.")
      .angle("imu_orientation_stddev_deg", &Config::imu_orientation_stddev, kStddev, "deg",
             "Upper limit of the standard deviation of the tilt at one key frame. It is reduced, "
             "but not below a quarter, where the tilt agrees with odometry.")
      .angle("imu_heading_stddev_deg", &Config::imu_heading_stddev, kStddev, "deg",
             "Standard deviation of the heading at one key frame; larger than that of the IMU, "
             "because neighbours have errors in common.")
      .angle("imu_acceleration_stddev_deg", &Config::imu_acceleration_stddev, kStddev, "deg",
             "Standard deviation of the vertical by acceleration at one key frame; motion adds to "
             "it.");
}

void describe_floors(config::Schema<Config>& schema) {
  schema
      .choice("floor_constraint", &Config::floor_constraint,
              {{"none", FloorConstraint::kNone},
               {"neighbours", FloorConstraint::kNeighbours},
               {"plane", FloorConstraint::kPlane}},
              "Floors of successive key frames as one plane each (safe on slopes), or all floors "
              "as a single plane (flat halls).")
      .angle("floor_stddev_deg", &Config::floor_stddev_rad, kStddev, "deg",
             "How much the slope of the floor differs from the plane, added to its covariance.")
      .real("floor_stddev_m", &Config::floor_stddev_m, kStddev, "m",
            "How much the height of the floor differs from the plane, added to its covariance.");
}

void describe_robust_kernels(config::Schema<Config>& schema) {
  const auto kernels = kernels_in_any_case();
  schema
      .choice("odometry_robust_kernel", &Config::odometry_robust_kernel, kernels,
              "Kernel of odometry constraints.")
      .choice("loop_robust_kernel", &Config::loop_robust_kernel, kernels,
              "Kernel of the loops that are used.")
      .choice("gnss_robust_kernel", &Config::gnss_robust_kernel, kernels,
              "Kernel of the GNSS positions that are used.")
      .choice("imu_robust_kernel", &Config::imu_robust_kernel, kernels,
              "Kernel of orientations, headings and accelerations.")
      .choice("floor_robust_kernel", &Config::floor_robust_kernel, kernels, "Kernel of floors.")
      .alias("odometry_edge_robust_kernel", "odometry_robust_kernel")
      .alias("loop_closure_edge_robust_kernel", "loop_robust_kernel")
      .alias("gps_edge_robust_kernel", "gnss_robust_kernel")
      .alias("imu_orientation_edge_robust_kernel", "imu_robust_kernel")
      .alias("imu_acceleration_edge_robust_kernel", "imu_robust_kernel")
      .alias("floor_edge_robust_kernel", "floor_robust_kernel")
      .real("robust_kernel_size", &Config::robust_kernel_size, {0.1, 100.0}, "standard deviations",
            "Scale of the kernels: larger residuals get less weight.");
}

void add_checks(config::Schema<Config>& schema) {
  schema
      .check([](const Config& c) -> std::string {
        if (!c.use_const_inf_matrix || !c.use_fitness_inf_matrix) return "";
        return "use_const_inf_matrix and use_fitness_inf_matrix exclude each other; set one of "
               "them to false";
      })
      .check([](const Config& c) -> std::string {
        const bool crossed = c.min_stddev_x > c.max_stddev_x || c.min_stddev_q > c.max_stddev_q;
        return crossed ? "min_stddev_x and min_stddev_q must not be above max_stddev_x and "
                         "max_stddev_q"
                       : "";
      })
      .check([](const Config& c) -> std::string {
        const auto& stddevs = c.fix_first_node_stddev;
        const bool positive = std::all_of(stddevs.begin(), stddevs.end(),
                                          [](double s) { return s >= 1e-6 && s <= 1e6; });
        return positive ? "" : "fix_first_node_stddev must hold numbers from 1e-06 to 1e+06";
      })
      .check([](const Config& c) -> std::string {
        return c.georeference_only && !c.use_gnss ? "georeference_only needs use_gnss: true" : "";
      });
}

/// In the order of the struct. A new factor gets a function of its own between those of the floors
/// and of the kernels, with its switch and its standard deviations; its kernel is one of the
/// kernels.
config::Schema<Config> make_schema() {
  config::Schema<Config> schema("back_end",
                                "Pose graph of the drive: constraints and when to solve");
  describe_use(schema);
  describe_triggers(schema);
  describe_odometry(schema);
  describe_loops(schema);
  describe_first_node(schema);
  describe_other_weights(schema);
  describe_gnss(schema);
  describe_imu(schema);
  describe_floors(schema);
  describe_robust_kernels(schema);
  add_checks(schema);
  return schema;
}

}  // namespace

const config::Schema<BackEndConfig>& BackEndConfig::schema() {
  static const config::Schema<BackEndConfig> schema = make_schema();
  return schema;
}

}  // namespace lidar_mapping::back_end
