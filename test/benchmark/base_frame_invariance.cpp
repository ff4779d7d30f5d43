// SPDX-License-Identifier: BSD-3-Clause
// How far the poses of the LiDAR differ where base_link lies elsewhere on the same vehicle:
//   base_frame_invariance --drive town --lidar vlp16 --duration 30 [--lidar-alone]
//   base_frame_invariance --folder DIRECTORY

#include <cstdio>
#include <exception>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>

#include "lidar_mapping/pipeline/folder_input.hpp"

#include "../front_end/base_frames.hpp"

namespace {

using namespace lidar_mapping;

std::vector<test::OtherBase> other_bases() {
  using test::other_base;
  return {other_base("ahead 1.5 m", {1.5, 0.0, 0.0}, 0.0, 0.0, 0.0),
          other_base("aside 1.5 m", {0.0, -1.5, 0.0}, 0.0, 0.0, 0.0),
          other_base("below 1.5 m", {0.0, 0.0, -1.5}, 0.0, 0.0, 0.0),
          other_base("yaw 90", {0.0, 0.0, 0.0}, 90.0, 0.0, 0.0),
          other_base("yaw 180", {0.0, 0.0, 0.0}, 180.0, 0.0, 0.0),
          other_base("pitch 30", {0.0, 0.0, 0.0}, 0.0, 30.0, 0.0),
          other_base("roll 180", {0.0, 0.0, 0.0}, 0.0, 0.0, 180.0),
          other_base("behind, yaw -90", {-1.5, 0.5, 0.3}, -90.0, 0.0, 0.0),
          other_base("above, pitch 30, roll 180", {0.4, -0.4, 1.5}, 0.0, 30.0, 180.0),
          other_base("corner, yaw 45, pitch -30, roll 10", {1.5, 1.5, -1.5}, 45.0, -30.0, 10.0)};
}

/// The scans of a folder, all in memory.
test::SensorData recorded(const std::string& folder) {
  pipeline::FolderInput input(folder);
  auto scans = std::make_shared<std::vector<preprocessing::RawScan>>();
  while (const auto next = input.next()) {
    const auto* scan = std::get_if<pipeline::RecordedScan>(&*next);
    if (scan == nullptr) continue;
    scans->push_back(scan->decode({}));
    scans->back().unpack();
    scans->back().frame_id = "lidar";
  }
  test::SensorData data;
  data.T_base_lidar = Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.7}};
  data.scan_count = scans->size();
  data.scan = [scans](std::size_t index) { return (*scans)[index]; };
  return data;
}

void print_table(const test::SensorData& data) {
  const test::SensorTrack usual = test::OdometryInOtherBase(data, {"usual", {}}).run();
  double way = 0.0;
  for (std::size_t i = 1; i < usual.T_first_lidar.size(); ++i) {
    way += (usual.T_first_lidar[i].translation - usual.T_first_lidar[i - 1].translation).norm();
  }
  std::printf("%zu scans, %.0f m, lost %zu, key frames %zu\n", usual.T_first_lidar.size(), way,
              usual.lost, usual.key_frames);
  for (const test::OtherBase& other : other_bases()) {
    const test::SensorTrack track = test::OdometryInOtherBase(data, other).run();
    const test::TrackDifference difference = test::difference_of(usual, track);
    std::printf("%-36s %12.6f mm %10.6f deg  lost %zu  key frames %zu\n", other.name.c_str(),
                1e3 * difference.metres, difference.degrees, track.lost, track.key_frames);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  simulation::DriveOptions options;
  std::string folder;
  double duration = 30.0;
  bool lidar_alone = false;
  CLI::App app{"Poses of the LiDAR with base_link in ten other places"};
  app.add_option("--drive", options.drive, "world and way")->capture_default_str();
  app.add_option("--lidar", options.lidar, "sensor")->capture_default_str();
  app.add_option("--imu", options.imu, "IMU")->capture_default_str();
  app.add_option("--seed", options.seed, "seed of the drive")->capture_default_str();
  app.add_option("--duration", duration, "s")->capture_default_str();
  app.add_flag("--lidar-alone", lidar_alone, "without IMU and velocity");
  app.add_option("--folder", folder, "recorded scans instead of a drive");
  CLI11_PARSE(app, argc, argv);
  options.duration = duration;
  try {
    if (!folder.empty()) {
      print_table(recorded(folder));
    } else {
      const simulation::Drive drive(options);
      print_table(test::sensor_data(drive, !lidar_alone));
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "base_frame_invariance: %s\n", error.what());
    return 1;
  }
}
