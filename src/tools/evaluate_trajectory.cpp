// Compares a trajectory with the truth: absolute, relative and KITTI's errors.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "json.hpp"
#include "number_checks.hpp"

namespace {

using namespace lidar_mapping;
using tools::Json;
using namespace lidar_mapping::evaluation;

struct Options {
  std::string truth;
  std::string estimate;
  bool align = false;
  double delta_m = 10.0;
  std::vector<double> lengths_m;
  std::size_t step = 1;
  std::string json;
  std::string plot;
};

Json to_json(const ErrorStatistics& statistics) {
  return {{"rmse", statistics.rmse},
          {"mean", statistics.mean},
          {"median", statistics.median},
          {"max", statistics.max}};
}

Json to_json(const PoseErrors& errors) {
  return {{"translation_m", to_json(errors.translation_m)},
          {"rotation_deg", to_json(errors.rotation_deg)}};
}

Json evaluate(const Options& options, const std::vector<PosePair>& pairs) {
  const std::vector<double> lengths =
      options.lengths_m.empty() ? usual_segment_lengths(pairs) : options.lengths_m;
  const KittiErrors kitti = kitti_errors(pairs, lengths, options.step);
  return {{"poses", pairs.size()},
          {"length_m", travelled_distances(pairs).back()},
          {"aligned", options.align},
          {"ape", to_json(absolute_pose_error(pairs))},
          {"rpe", to_json(relative_pose_error(pairs, options.delta_m))},
          {"rpe_delta_m", options.delta_m},
          {"kitti",
           {{"translation_percent", kitti.translation_percent},
            {"rotation_deg_per_100m", kitti.rotation_deg_per_100m},
            {"segments", kitti.segments},
            {"segment_lengths_m", kitti.lengths_m},
            {"start_step", options.step}}}};
}

void print(const Json& result) {
  const auto row = [](const char* name, const Json& statistics, const char* unit) {
    std::printf("%-24s rmse %9.4f  mean %9.4f  median %9.4f  max %9.4f  %s\n", name,
                statistics["rmse"].get<double>(), statistics["mean"].get<double>(),
                statistics["median"].get<double>(), statistics["max"].get<double>(), unit);
  };
  std::printf("%zu poses, %.1f m%s\n", result["poses"].get<std::size_t>(),
              result["length_m"].get<double>(), result["aligned"] ? ", rigidly aligned" : "");
  row("APE translation", result["ape"]["translation_m"], "m");
  row("APE rotation", result["ape"]["rotation_deg"], "deg");
  row("RPE translation", result["rpe"]["translation_m"], "m");
  row("RPE rotation", result["rpe"]["rotation_deg"], "deg");
  const Json& kitti = result["kitti"];
  if (kitti["segments"] == 0) {
    std::printf("KITTI: the path is shorter than the shortest segment\n");
    return;
  }
  std::printf("KITTI relative error     %.4f %%  %.4f deg/100 m  (segments of %s m)\n",
              kitti["translation_percent"].get<double>(),
              kitti["rotation_deg_per_100m"].get<double>(),
              kitti["segment_lengths_m"].dump().c_str());
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush()) throw FileError("cannot write " + path);
}

/// The plot is made by a script beside this program, from a file of all poses.
void plot(const std::string& picture, const std::vector<PosePair>& pairs) {
  Json poses = Json::array();
  const std::vector<double> way = travelled_distances(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d& t = pairs[i].truth.translation;
    const Eigen::Vector3d& e = pairs[i].estimate.translation;
    const Pose error = pairs[i].truth.inverse() * pairs[i].estimate;
    poses.push_back({way[i], t.x(), t.y(), t.z(), e.x(), e.y(), e.z(), error.translation.norm(),
                     rotation_angle(error.rotation) * 180.0 / M_PI});
  }
  const std::string data = picture + ".json";
  write_text(data, poses.dump());
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string script = (program / "plot_trajectories.py").string();
  const std::string command = "'" + script + "' '" + data + "' '" + picture + "'";
  const int status = std::system(command.c_str());
  std::filesystem::remove(data);
  if (status != 0) throw FileError("could not plot to " + picture + " with " + script);
}

void run(const Options& options) {
  std::vector<PosePair> pairs =
      associate(read_trajectory(options.truth), read_trajectory(options.estimate));
  if (pairs.empty()) {
    throw InputError("no pose of " + options.estimate + " lies within the time of " +
                     options.truth + "; check the clocks of both");
  }
  if (options.align) pairs = aligned(pairs, rigid_alignment(pairs));
  const Json result = evaluate(options, pairs);
  print(result);
  if (!options.json.empty()) write_text(options.json, result.dump(2) + "\n");
  if (!options.plot.empty()) plot(options.plot, pairs);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Errors of a trajectory against the truth (KITTI or TUM files)"};
  Options options;
  app.add_option("truth", options.truth, "true trajectory")->required();
  app.add_option("estimate", options.estimate, "trajectory to judge")->required();
  app.add_flag("--align", options.align, "move the estimate rigidly onto the truth first");
  app.add_option("--delta", options.delta_m, "way of the relative pose error, m; 0: pose to pose")
      ->check(tools::not_negative());
  app.add_option("--lengths", options.lengths_m, "segment lengths of KITTI's error, m")
      ->check(tools::above_zero());
  app.add_option("--step", options.step, "start KITTI's segments at every n-th pose")
      ->check(tools::above_zero());
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_option("--plot", options.plot, "write a picture of both trajectories and the error");
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::cerr << "evaluate_trajectory: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
