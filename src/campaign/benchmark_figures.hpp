// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/evaluation/association.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

#include "json.hpp"

namespace lidar_mapping::campaign {

/// What the benchmark notes of one scan.
struct ScanRecord {
  Stamp stamp = 0;
  Pose T_odom_base;
  double wall_ms = 0.0;
  double cpu_ms = 0.0;
  bool key_frame = false;
  std::uint32_t segment = 0;
  front_end::FrontEndStatus status;
};

/// Milliseconds of CPU time that this process has used, over all of its threads.
double cpu_time_ms();

/// scans, mean_ms, median_ms, p95_ms, max_ms, cpu_ms, step_ms, degenerate, rescued and the like.
json::Json figures_of(const std::vector<ScanRecord>& records);
/// translation_error_percent, rotation_error_deg_per_100m, ape_rmse, segment_lengths_m.
json::Json errors_of(const std::vector<evaluation::PosePair>& pairs);
/// wrong_steps, silent_steps, false_alarms (step_checker.hpp); pair i is that of record i.
json::Json steps_of(const std::vector<evaluation::PosePair>& pairs,
                    const std::vector<ScanRecord>& records);

/// A line per scan.
std::string to_csv(const std::vector<ScanRecord>& records);
/// The estimated poses.
Trajectory trajectory_of(const std::vector<ScanRecord>& records);

}  // namespace lidar_mapping::campaign
