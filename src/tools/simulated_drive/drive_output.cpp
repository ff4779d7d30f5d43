// SPDX-License-Identifier: BSD-3-Clause
#include "simulated_drive/drive_output.hpp"

#include <algorithm>
#include <vector>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "command_line/progress_bar.hpp"

namespace lidar_mapping::tools {

void for_each_scan(const simulation::Drive& drive, int threads,
                   const std::function<void(std::size_t, const simulation::SimulatedScan&)>& take) {
  constexpr std::size_t kBatch = 16;  // scans in memory; chosen: a few for each thread
  ProgressBar progress("simulating scans", drive.scan_count());
  std::vector<simulation::SimulatedScan> batch(kBatch);
  for (std::size_t first = 0; first < drive.scan_count(); first += kBatch) {
    const std::size_t count = std::min(kBatch, drive.scan_count() - first);
    parallel_chunks(count, 1, threads,
                    [&](std::size_t i, std::size_t) { batch[i] = drive.scan(first + i); });
    for (std::size_t i = 0; i < count; ++i) take(first + i, batch[i]);
    progress.show(first + count);
  }
}

void write_truth(const simulation::Drive& drive, const std::string& path) {
  Trajectory truth;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Stamp stamp = drive.scan_stamp(i);
    truth.poses.push_back({stamp, drive.trajectory().pose(stamp)});
  }
  write_text_atomically(path, to_tum(truth));
}

}  // namespace lidar_mapping::tools
