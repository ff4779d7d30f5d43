// SPDX-License-Identifier: BSD-3-Clause
// Simulates a drive and writes it as a bag with KITTI's topics, or as a folder of scans.

#include <cstdio>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "command_line/number_checks.hpp"
#include "command_line/overwriting.hpp"
#include "command_line/run_command.hpp"
#include "simulated_drive/drive_output.hpp"

namespace {

using namespace lidar_mapping;

struct Options {
  simulation::DriveOptions drive;
  tools::BagContent content;
  std::string bag;
  std::string folder;
  std::string truth;
  std::vector<std::string> outages;
  std::vector<std::string> jumps;
  std::vector<std::string> faults;
  int threads = 0;
  bool force = false;
  const CLI::Option* rounds = nullptr;
};

/// The two numbers of "A:B".
std::pair<double, double> split(const std::string& text, const char* option) {
  double first = 0.0, second = 0.0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf%c", &first, &second, &rest) != 2) {
    throw ConfigError(std::string(option) + ": '" + text + "' is not of the form A:B");
  }
  return {first, second};
}

/// All faults, as they are written on the command line.
std::string fault_formats() {
  std::vector<std::string> formats = simulation::scan_fault_formats();
  for (const std::string& of_imu : simulation::imu_fault_formats()) formats.push_back(of_imu);
  for (const auto& [name, fault] : tools::bag_faults()) formats.push_back(name);
  return joined(formats, "; ");
}

/// Adds a fault of the bag, of the scans or of the IMU.
void add_fault(const std::string& text, Options& options) {
  const auto of_bag = tools::bag_faults().find(text);
  if (of_bag != tools::bag_faults().end()) {
    options.content.faults.insert(of_bag->second);
    return;
  }
  try {
    simulation::add_fault(options.drive, text);
  } catch (const ConfigError& error) {
    throw ConfigError(std::string("--") + error.what() + " (all faults: " + fault_formats() + ")");
  }
}

void add_arguments(CLI::App& app, Options& options) {
  simulation::DriveOptions& drive = options.drive;
  app.add_option("bag", options.bag, "bag to write");
  app.add_option("--drive", drive.drive, "world and path")
      ->check(CLI::IsMember(simulation::drive_names()))
      ->capture_default_str();
  app.add_option("--lidar", drive.lidar, "sensor")
      ->check(CLI::IsMember(simulation::lidar_names()))
      ->capture_default_str();
  app.add_option("--second-lidar", options.content.second_lidar,
                 "a further sensor at the rear, in bags on /second/points")
      ->check(CLI::IsMember(simulation::lidar_names()));
  app.add_option("--seed", drive.seed, "seed of the world and of all noise")->capture_default_str();
  app.add_option("--pass", drive.pass, "so many days later in the same town: own traffic and noise")
      ->capture_default_str();
  app.add_flag("--reverse", drive.reverse, "the same route in the opposite direction");
  app.add_option("--parked", drive.parked, "day of the parked cars: each has others")
      ->capture_default_str();
  app.add_option("--start", drive.start, "leave out so many seconds of the beginning");
  app.add_option("--duration", drive.duration,
                 "end the drive after so many seconds, counted from its beginning");
  options.rounds =
      app.add_option("--rounds", drive.rounds, "rounds of the drive 'city'")->capture_default_str();
  app.add_option("--scan-rate", drive.scan_rate, "turns per second")->capture_default_str();
  app.add_option("--range-noise", drive.range_noise, "standard deviation, m")
      ->check(tools::not_negative())
      ->capture_default_str();
  const auto without = [&app](const std::string& flag, bool& there, const std::string& meaning) {
    app.add_flag_callback(
        flag, [&there] { there = false; }, meaning);
  };
  without("--no-movers", drive.movers, "no moving cars and people");
  app.add_flag("--undistorted", drive.undistorted,
               "take each scan in one instant, without time per point");
  app.add_option("--imu", drive.imu, "grade of the IMU")
      ->check(CLI::IsMember(simulation::imu_names()))
      ->capture_default_str();
  app.add_option("--fault", options.faults,
                 "faults of the scans, the IMU or the bag (repeatable): " + fault_formats())
      ->allow_extra_args(false);
  without("--no-lidar", options.content.lidar, "leave the clouds out");
  without("--no-imu", options.content.imu, "leave the IMU out");
  without("--no-gnss", options.content.gnss, "leave GNSS out");
  without("--no-velocity", options.content.velocity, "leave the velocity out");
  app.add_option("--gnss-rate", drive.gnss_rate, "fixes per second")->capture_default_str();
  app.add_option("--gnss-noise", drive.gnss_noise, "standard deviation east and north, m")
      ->check(tools::not_negative())
      ->capture_default_str();
  app.add_option("--gnss-outage", options.outages, "START:END without a fix, s (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--gnss-jump", options.jumps,
                 "T:METRES, fixes beside the truth for ten seconds (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--threads", options.threads, "threads; 0: all cores")
      ->check(tools::not_negative())
      ->capture_default_str();
  app.add_option("--truth", options.truth, "write the true poses of base_link to this TUM file");
  app.add_option("--kitti", options.folder, "write the scans into this new folder");
  app.add_flag("--force", options.force, "overwrite files that exist");
}

/// The part of the drive that is written, by --start and --duration.
void print(const Options& options, const simulation::Drive& drive) {
  const std::size_t scans = drive.scan_count();
  const Stamp begin = scans > 0 ? drive.scan_stamp(0) : 0;
  const Stamp end = scans > 0 ? drive.scan_stamp(scans - 1) : 0;
  std::printf("%s, seed %llu: %.0f m, %.0f s, %zu scans of %s\n", options.drive.drive.c_str(),
              static_cast<unsigned long long>(options.drive.seed),
              drive.trajectory().length(begin, end), to_seconds(end - begin), scans,
              drive.lidar().name.c_str());
}

void run(Options& options) {
  for (const std::string& text : options.outages) {
    const auto [begin, end] = split(text, "--gnss-outage");
    options.drive.gnss_outages.push_back({begin, end});
  }
  for (const std::string& text : options.jumps) {
    const auto [at, metres] = split(text, "--gnss-jump");
    options.drive.gnss_jumps.push_back({at, metres});
  }
  for (const std::string& text : options.faults) add_fault(text, options);
  if (options.content.has(tools::BagFault::kDeskewedTwice)) options.drive.undistorted = true;
  if (options.rounds->count() > 0 && options.drive.drive != "city") {
    throw ConfigError("--rounds has no meaning for the drive '" + options.drive.drive +
                      "'; only 'city' goes round and round");
  }
  if (options.bag.empty() && options.folder.empty() && options.truth.empty()) {
    throw ConfigError("nothing to write; name a bag, --kitti FOLDER or --truth FILE");
  }
  tools::check_overwriting({options.bag, options.truth}, options.force);
  const simulation::Drive drive(options.drive);
  print(options, drive);
  if (!options.truth.empty()) tools::write_truth(drive, options.truth);
  if (!options.folder.empty()) tools::write_folder(drive, options.folder, options.threads);
  if (!options.bag.empty()) tools::write_bag(drive, options.bag, options.content, options.threads);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Simulates a drive and writes it as a bag or as a folder of scans"};
  Options options;
  add_arguments(app, options);
  return tools::run_command(app, argc, argv, [&] { run(options); });
}
