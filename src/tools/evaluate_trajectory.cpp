// SPDX-License-Identifier: BSD-3-Clause
// Compares a trajectory with the truth: absolute, relative and KITTI's errors.

#include <cstdio>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/evaluation/lever_arm.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "command_line/child_program.hpp"
#include "command_line/number_checks.hpp"
#include "command_line/run_command.hpp"
#include "comparison/trajectory_hints.hpp"
#include "json.hpp"

namespace {

using namespace lidar_mapping;
using json::Json;
using namespace lidar_mapping::evaluation;

struct Options {
  std::string truth;
  std::string estimate;
  bool align = false;
  bool correct_scale = false;
  bool align_origin = false;
  std::size_t to_align = 0;  ///< poses; 0: all
  std::vector<double> lever_arm;
  std::vector<double> lever_rotation_deg;
  double delta_m = 10.0;
  std::vector<double> lengths_m;
  std::size_t step = 1;
  std::string json;
  std::string plot;
};

/// Figures over no errors are null.
Json to_json(const ErrorStatistics& statistics) {
  const auto figure = [&](double value) { return statistics.count == 0 ? Json() : Json(value); };
  return {{"count", statistics.count},
          {"rmse", figure(statistics.rmse)},
          {"mean", figure(statistics.mean)},
          {"median", figure(statistics.median)},
          {"max", figure(statistics.max)}};
}

Json to_json(const PoseErrors& errors) {
  return {{"translation_m", to_json(errors.translation_m)},
          {"rotation_deg", to_json(errors.rotation_deg)}};
}

/// Describes the alignment of the estimate with the truth.
struct Alignment {
  std::string name = "none";
  double scale = 1.0;
};

/// T_estimate_truth: pose of the frame of the truth on the vehicle.
Pose lever_arm_of(const Options& options) {
  std::vector<double> numbers = options.lever_arm;
  numbers.resize(3);  // no lever arm is one of zero
  for (const double angle : options.lever_rotation_deg) numbers.push_back(angle);
  return pose_from_degrees(numbers);
}

/// Alignment as by evo: a scale, a rigid motion, or both, from all poses or the first ones.
Alignment align(const Options& options, std::vector<PosePair>& pairs) {
  std::vector<PosePair> first = pairs;
  if (options.to_align > 0 && options.to_align < first.size()) first.resize(options.to_align);
  Alignment alignment;
  if (options.correct_scale) {
    const SimilarityAlignment found = similarity_alignment(first);
    pairs = scaled(pairs, found.scale);
    if (options.align) pairs = aligned(pairs, found.T_truth_estimate);
    alignment = {options.align ? "similarity" : "scale", found.scale};
  } else if (options.align) {
    pairs = aligned(pairs, rigid_alignment(first));
    alignment.name = "rigid";
  } else if (options.align_origin) {
    pairs = aligned(pairs, pairs.front().truth * pairs.front().estimate.inverse());
    alignment.name = "origin";
  }
  return alignment;
}

Json evaluate(const Options& options, const std::vector<PosePair>& pairs) {
  const std::vector<double> lengths =
      options.lengths_m.empty() ? usual_segment_lengths(pairs) : options.lengths_m;
  const KittiErrors kitti = kitti_errors(pairs, lengths, options.step);
  const auto of_kitti = [&](double value) { return kitti.segments == 0 ? Json() : Json(value); };
  return {{"poses", pairs.size()},
          {"length_m", travelled_distances(pairs).back()},
          {"ape", to_json(absolute_pose_error(pairs))},
          {"rpe", to_json(relative_pose_error(pairs, options.delta_m))},
          {"rpe_delta_m", options.delta_m},
          {"kitti",
           {{"translation_percent", of_kitti(kitti.translation_percent)},
            {"rotation_deg_per_100m", of_kitti(kitti.rotation_deg_per_100m)},
            {"segments", kitti.segments},
            {"segment_lengths_m", kitti.lengths_m},
            {"start_step", options.step}}}};
}

void print(const Json& result) {
  const double metres = result["rpe_delta_m"];
  const std::string delta = metres > 0.0 ? formatted("%g m", metres) : "each step";
  const auto row = [&](const std::string& name, const Json& statistics, const char* unit) {
    if (statistics["count"] == 0) {
      std::printf("%-24s the path is shorter than %s\n", name.c_str(), delta.c_str());
      return;
    }
    std::printf("%-24s rmse %9.4f  mean %9.4f  median %9.4f  max %9.4f  %s\n", name.c_str(),
                statistics["rmse"].get<double>(), statistics["mean"].get<double>(),
                statistics["median"].get<double>(), statistics["max"].get<double>(), unit);
  };
  std::printf("%zu poses, %.1f m, alignment: %s", result["poses"].get<std::size_t>(),
              result["length_m"].get<double>(), result["alignment"].get<std::string>().c_str());
  const double scale = result["scale"];
  scale == 1.0 ? std::printf("\n") : std::printf(", scale %.6f\n", scale);
  const LeftOut left_out{result["left_out"]["outside"], result["left_out"]["in_gaps"]};
  const std::string reason = reason_of(left_out, "the truth");
  if (!reason.empty()) std::printf("left out: %s\n", reason.c_str());
  row("APE translation", result["ape"]["translation_m"], "m");
  row("APE rotation", result["ape"]["rotation_deg"], "deg");
  row("RPE translation, " + delta, result["rpe"]["translation_m"], "m");
  row("RPE rotation, " + delta, result["rpe"]["rotation_deg"], "deg");
  const Json& kitti = result["kitti"];
  if (kitti["segments"] == 0) {
    std::printf("KITTI: the path is shorter than the shortest segment\n");
    return;
  }
  std::printf("KITTI relative error     %.4f %%  %.4f deg/100 m  (segments of %s m)\n",
              kitti["translation_percent"].get<double>(),
              kitti["rotation_deg_per_100m"].get<double>(),
              json::dumped(kitti["segment_lengths_m"]).c_str());
}

/// Draws the plot by a script beside this program, from a file of all poses.
void plot(const std::string& picture, const std::vector<PosePair>& pairs) {
  Json poses = Json::array();
  const std::vector<double> distance = travelled_distances(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d& t = pairs[i].truth.translation;
    const Eigen::Vector3d& e = pairs[i].estimate.translation;
    const Pose error = pairs[i].truth.inverse() * pairs[i].estimate;
    poses.push_back({distance[i], t.x(), t.y(), t.z(), e.x(), e.y(), e.z(),
                     error.translation.norm(), rotation_angle(error.rotation) * kDegPerRad});
  }
  const std::string data = picture + ".json";
  write_text_atomically(data, json::dumped(poses));
  tools::run_program(tools::program_beside("plot_trajectories.py"), {data, picture});
  std::filesystem::remove(data);
}

void check(const Options& options) {
  if (options.align_origin && (options.align || options.correct_scale)) {
    throw ConfigError("--align-origin and --align or --correct-scale exclude each other");
  }
  if (options.to_align > 0 && !options.align && !options.correct_scale) {
    throw ConfigError("--n-to-align has no meaning without --align or --correct-scale");
  }
}

void run(const Options& options) {
  const Trajectory truth = read_trajectory(options.truth);
  const Trajectory estimate = read_trajectory(options.estimate);
  const LeftOut counts = left_out(truth, estimate);
  std::vector<PosePair> pairs = associate(truth, estimate);
  if (pairs.empty()) {
    throw InputError("no pose of " + options.estimate + " has a true one: " +
                     reason_of(counts, options.truth) + "; " + remedy_for(counts));
  }
  pairs = moved_on_vehicle(pairs, lever_arm_of(options));
  const Alignment alignment = align(options, pairs);
  const auto hints = tools::trajectory_hints(
      pairs,
      {alignment.name != "none", !options.lever_arm.empty(), !options.lever_rotation_deg.empty()});
  Json result = evaluate(options, pairs);
  result["left_out"] = {{"outside", counts.outside}, {"in_gaps", counts.in_gaps}};
  result["alignment"] = alignment.name;
  result["scale"] = alignment.scale;
  result["lever_arm_m"] = options.lever_arm;
  result["lever_rotation_deg"] = options.lever_rotation_deg;
  result["hints"] = hints;
  print(result);
  for (const std::string& hint : hints) std::printf("hint: %s\n", hint.c_str());
  if (!options.json.empty()) write_text_atomically(options.json, json::dumped(result, 2) + "\n");
  if (!options.plot.empty()) plot(options.plot, pairs);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Errors of a trajectory against the truth (KITTI or TUM files)"};
  Options options;
  app.add_option("truth", options.truth, "true trajectory")->required();
  app.add_option("estimate", options.estimate, "trajectory to judge")->required();
  app.add_flag("-a,--align", options.align, "move the estimate rigidly onto the truth first");
  app.add_flag("-s,--correct-scale", options.correct_scale,
               "scale the estimate; with --align a similarity is found");
  app.add_option("--n-to-align", options.to_align, "align by so many of the first poses alone")
      ->check(tools::at_least(3.0, true, "3 or more"));
  app.add_flag("--align-origin", options.align_origin,
               "lay the first pose onto the first true one");
  app.add_option("--lever-arm", options.lever_arm,
                 "X Y Z of the point that the truth is of, in the estimated frame, m")
      ->expected(3);
  app.add_option("--lever-rotation", options.lever_rotation_deg,
                 "ROLL PITCH YAW of the truth's axes in the estimated frame, deg")
      ->expected(3);
  app.add_option("--delta", options.delta_m,
                 "path length of the relative pose error, m; 0: pose to pose")
      ->check(tools::not_negative());
  app.add_option("--lengths", options.lengths_m, "segment lengths of KITTI's error, m")
      ->check(tools::above_zero());
  app.add_option("--step", options.step, "start KITTI's segments at every n-th pose")
      ->check(tools::above_zero());
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_option("--plot", options.plot, "write a picture of both trajectories and the error");
  return tools::run_command(app, argc, argv, [&] {
    check(options);
    run(options);
  });
}
