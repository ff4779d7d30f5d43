// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "simulated_drive/drive_output.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;

template <typename T>
void write_values(const fs::path& path, const std::vector<T>& values) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(T)));
  if (!file.flush()) throw FileError("cannot write " + path.string() + "; is the disk full?");
}

std::string file_name(std::size_t index, const char* ending) {
  return formatted("%06zu.%s", index, ending);
}

std::string times_text(const simulation::Drive& drive) {
  std::string text;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    text += formatted("%.9f\n", to_seconds(drive.reported_stamp(i) - drive.reported_stamp(0)));
  }
  return text;
}

/// Poses of the LiDAR relative to the first, as KITTI has them for its camera.
Trajectory lidar_poses(const simulation::Drive& drive) {
  const Pose& T_base_lidar = drive.mounting().T_base_lidar;
  const Pose T_first_map = (drive.trajectory().pose(drive.scan_stamp(0)) * T_base_lidar).inverse();
  Trajectory poses;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Stamp stamp = drive.scan_stamp(i);
    poses.poses.push_back({stamp, T_first_map * drive.trajectory().pose(stamp) * T_base_lidar});
  }
  return poses;
}

}  // namespace

void write_folder(const simulation::Drive& drive, const std::string& path, int threads) {
  const fs::path root(path);
  if (fs::exists(root) && !fs::is_empty(root)) {
    throw FileError(path + " is not empty; name a new folder");
  }
  for (const char* part : {"velodyne", "point_times", "labels"}) {
    fs::create_directories(root / part);
  }
  write_text_atomically((root / "times.txt").string(), times_text(drive));
  write_text_atomically((root / "poses.txt").string(), to_kitti(lidar_poses(drive)));
  for_each_scan(drive, threads, [&](std::size_t i, const simulation::SimulatedScan& scan) {
    write_values(root / "velodyne" / file_name(i, "bin"), scan.cloud.points);
    write_values(root / "labels" / file_name(i, "u8"), scan.moving);
    if (scan.cloud.has_times()) {
      write_values(root / "point_times" / file_name(i, "f32"), scan.cloud.times);
    }
  });
}

}  // namespace lidar_mapping::tools
