// SPDX-License-Identifier: BSD-3-Clause
// Runs the front end over recorded scans and reports its speed and accuracy.

#include <chrono>
#include <functional>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/load.hpp"

#include "benchmark_figures.hpp"
#include "command_line/number_checks.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/run_command.hpp"
#include "comparison/baseline_odometry.hpp"
#include "json.hpp"
#include "parameters/config_path.hpp"
#include "recording.hpp"

namespace {

using namespace lidar_mapping;
using campaign::ScanRecord;
using json::Json;

/// Name of a whole front end instead of a method: that of lidar_localization
/// (baseline_odometry.hpp).
const std::string kBaseline = "LIDAR_LOCALIZATION";

struct Options {
  std::string recording;
  std::string topic;
  std::string method;
  int threads = 1;
  std::string config;
  std::vector<std::string> parameters;
  std::size_t every = 1;
  std::size_t first = 0;
  std::size_t limit = 0;
  double elevation_correction_deg = 0.0;
  bool time_from_azimuth = false;
  std::string truth;
  std::string poses;
  std::string times;
  std::string json;
};

/// Configuration from the defaults, the file, the method and single parameters, in growing
/// priority.
front_end::FrontEndConfig make_config(const Options& options) {
  std::vector<config::Source> sources;
  const std::string file = tools::only_stage_file(options.config, "front_end");
  if (!file.empty()) sources.push_back(config::read_yaml_file(file));
  if (!options.method.empty() && options.method != kBaseline) {
    sources.push_back(config::parse_yaml("registration_method: " + options.method, "--method"));
  }
  sources.push_back(config::parse_yaml("threads: " + std::to_string(options.threads), "--threads"));
  for (const std::string& parameter : options.parameters) {
    sources.push_back(config::parse_yaml(parameter, "--parameter"));
  }
  return config::load<front_end::FrontEndConfig>(sources);
}

using Process = std::function<front_end::FrontEndResult(const Scan&)>;

Process make_process(const Options& options, const front_end::FrontEndConfig& config,
                     const Pose& T_base_sensor) {
  if (options.method == kBaseline) {
    return [odometry = tools::baseline_odometry(), T_base_sensor](const Scan& scan) {
      return odometry({scan.stamp, transformed(scan.cloud, T_base_sensor)});
    };
  }
  const auto front_end = std::make_shared<front_end::FrontEnd>(config);
  front_end->set_sensor_pose(T_base_sensor);
  return [front_end](const Scan& scan) { return front_end->process(scan); };
}

/// Makes the last records final.
void finalize(const std::vector<front_end::FrontEndResult>& finalized,
              std::vector<ScanRecord>& records) {
  auto record = records.end() - static_cast<std::ptrdiff_t>(finalized.size());
  for (const front_end::FrontEndResult& result : finalized) {
    record->T_odom_base = result.T_odom_base;
    record->key_frame = result.key_frame.has_value();
    ++record;
  }
}

/// The time of a scan is that from the cloud in memory to the pose.
void add_timed(const Process& process, const Scan& scan, std::vector<ScanRecord>& records) {
  const double cpu_before = campaign::cpu_time_ms();
  const auto before = std::chrono::steady_clock::now();
  const front_end::FrontEndResult result = process(scan);
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - before;
  ScanRecord record;
  record.cpu_ms = campaign::cpu_time_ms() - cpu_before;
  record.wall_ms = wall.count();
  record.stamp = result.stamp;
  record.T_odom_base = result.T_odom_base;
  record.key_frame = result.key_frame.has_value();
  record.segment = result.segment;
  record.status = result.status;
  finalize(result.finalized, records);
  records.push_back(record);
}

/// Indices of the scans that are used.
std::vector<std::size_t> chosen_scans(const Options& options, std::size_t count) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = options.first; i < count; i += options.every) {
    if (options.limit > 0 && chosen.size() == options.limit) break;
    chosen.push_back(i);
  }
  if (chosen.empty()) {
    throw InputError("--first " + std::to_string(options.first) + " leaves none of the " +
                     std::to_string(count) + " scans of " + options.recording);
  }
  return chosen;
}

/// Line i of a KITTI file is scan i of the folder; a TUM file has stamps.
std::vector<evaluation::PosePair> paired(const Trajectory& truth,
                                         const std::vector<std::size_t>& scans,
                                         const std::vector<ScanRecord>& records) {
  if (truth.has_stamps) return evaluation::associate(truth, campaign::trajectory_of(records));
  if (scans.back() >= truth.poses.size()) {
    throw InputError("the truth has " + std::to_string(truth.poses.size()) + " poses, but scan " +
                     std::to_string(scans.back()) + " was used");
  }
  std::vector<evaluation::PosePair> pairs;
  for (std::size_t k = 0; k < records.size(); ++k) {
    pairs.push_back({records[k].stamp, truth.poses[scans[k]].pose, records[k].T_odom_base});
  }
  return pairs;
}

void write_wanted(const std::string& path, const std::string& text) {
  if (!path.empty()) write_text_atomically(path, text);
}

void run(const Options& options) {
  const front_end::FrontEndConfig config = make_config(options);
  const std::string notice = registration::describe_substitution(config.registration);
  if (!notice.empty()) std::cerr << "odometry_benchmark: " << notice << "\n";
  const recordings::Recording recording = recordings::open_recording(
      options.recording, options.topic,
      {options.elevation_correction_deg * kRadPerDeg, options.time_from_azimuth});
  const std::vector<std::size_t> scans = chosen_scans(options, recording.size);

  const double memory_before = tools::peak_mebibytes();
  const Process process = make_process(options, config, recording.T_base_sensor);
  std::vector<ScanRecord> records;
  for (const std::size_t i : scans) add_timed(process, recording.scan(i), records);

  Json result = {
      {"recording", options.recording},
      {"method", options.method.empty() ? to_string(config.registration.method) : options.method},
      {"threads", options.threads}};
  result.update(campaign::figures_of(records));
  result["peak_memory_mb"] = tools::peak_mebibytes();
  result["memory_over_start_mb"] = tools::peak_mebibytes() - memory_before;
  if (!options.truth.empty()) {
    const auto pairs = paired(read_trajectory(options.truth), scans, records);
    result.update(campaign::errors_of(pairs));
    if (pairs.size() == records.size()) result.update(campaign::steps_of(pairs, records));
  }
  write_wanted(options.poses, to_kitti(campaign::trajectory_of(records)));
  write_wanted(options.times, campaign::to_csv(records));
  write_wanted(options.json, json::dumped(result, 2) + "\n");
  std::cout << json::dumped(result, 2) << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Odometry over recorded scans: time, drift, state"};
  Options options;
  app.add_option("recording", options.recording, "folder with velodyne/NNNNNN.bin, or bag")
      ->required();
  app.add_option("--topic", options.topic, "topic of a bag; else its first PointCloud2");
  app.add_option(
      "--method", options.method,
      "registration_method, or " + kBaseline + " for the front end of lidar_localization");
  app.add_option("--threads", options.threads, "at most so many threads; 0: all cores");
  app.add_option("--config", options.config,
                 std::string(tools::kConfigHelp) + "; parameters of the front end");
  app.add_option("--parameter", options.parameters,
                 "one parameter more, as 'name: value' (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--every", options.every, "use every n-th scan only")->check(tools::above_zero());
  app.add_option("--first", options.first, "begin with this scan");
  app.add_option("--limit", options.limit, "at most so many scans");
  app.add_option("--elevation-correction", options.elevation_correction_deg,
                 "turn every point upward by this angle, deg (0.205 for KITTI)");
  app.add_flag("--time-from-azimuth", options.time_from_azimuth,
               "times of the points from their azimuth, for KITTI's raw scans");
  app.add_option("--truth", options.truth, "true poses (KITTI or TUM), read after the run");
  app.add_option("--poses", options.poses, "write the poses, KITTI's 12 numbers a line");
  app.add_option("--times", options.times, "write a CSV line per scan");
  app.add_option("--json", options.json, "write the figures");
  return tools::run_command(app, argc, argv, [&] { run(options); });
}
