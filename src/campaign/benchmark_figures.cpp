// SPDX-License-Identifier: BSD-3-Clause
#include "benchmark_figures.hpp"

#include <algorithm>
#include <ctime>
#include <numeric>
#include <sstream>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "step_checker.hpp"

namespace lidar_mapping::campaign {

namespace {

using front_end::TrackingState;

double mean_of(const std::vector<double>& values) {
  return values.empty() ? 0.0
                        : std::accumulate(values.begin(), values.end(), 0.0) /
                              static_cast<double>(values.size());
}

/// Mean over all scans, also over those that did without the step.
json::Json step_times(const std::vector<ScanRecord>& records) {
  json::Json steps = json::Json::object();
  for (const ScanRecord& record : records) {
    for (const auto& [name, seconds] : record.status.step_seconds) {
      steps[name] = steps.value(name, 0.0) + 1e3 * seconds / static_cast<double>(records.size());
    }
  }
  return steps;
}

/// "dense sampling" -> "dense_sampling_ms".
std::string column_name(std::string step) {
  std::replace(step.begin(), step.end(), ' ', '_');
  return step + "_ms";
}

double step_ms(const ScanRecord& record, const std::string& step) {
  double sum = 0.0;
  for (const auto& [name, seconds] : record.status.step_seconds) {
    if (name == step) sum += 1e3 * seconds;
  }
  return sum;
}

}  // namespace

double cpu_time_ms() {
  return 1e3 * static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

json::Json figures_of(const std::vector<ScanRecord>& records) {
  std::vector<double> wall, cpu;
  for (const ScanRecord& record : records) {
    wall.push_back(record.wall_ms);
    cpu.push_back(record.cpu_ms);
  }
  const auto flagged = [&](auto flag) {
    return std::count_if(records.begin(), records.end(), flag);
  };
  const auto in_state = [&](TrackingState state) {
    return flagged([=](const ScanRecord& r) { return r.status.state == state; });
  };
  return {{"scans", records.size()},
          {"mean_ms", mean_of(wall)},
          {"median_ms", quantile(wall, 0.5)},
          {"p95_ms", quantile(wall, 0.95)},
          {"max_ms", quantile(wall, 1.0)},
          {"cpu_ms", mean_of(cpu)},
          {"cpu_median_ms", quantile(cpu, 0.5)},
          {"cpu_p95_ms", quantile(cpu, 0.95)},
          {"cpu_max_ms", quantile(cpu, 1.0)},
          {"step_ms", step_times(records)},
          {"key_frames", flagged([](const ScanRecord& r) { return r.key_frame; })},
          {"degenerate", in_state(TrackingState::kDegenerate)},
          {"degraded", in_state(TrackingState::kDegraded)},
          {"lost", in_state(TrackingState::kLost)},
          {"rescued", flagged([](const ScanRecord& r) { return r.status.rescued; })},
          {"repeated", flagged([](const ScanRecord& r) { return r.status.repeated; })},
          {"elevation_shift_deg",
           records.empty() ? 0.0 : records.back().status.elevation_shift * kDegPerRad}};
}

json::Json errors_of(const std::vector<evaluation::PosePair>& pairs) {
  const auto errors = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  const auto on_truth = evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));
  return {{"translation_error_percent", errors.translation_percent},
          {"rotation_error_deg_per_100m", errors.rotation_deg_per_100m},
          {"ape_rmse", evaluation::absolute_pose_error(on_truth).translation_m.rmse},
          {"segment_lengths_m", errors.lengths_m}};
}

json::Json steps_of(const std::vector<evaluation::PosePair>& pairs,
                    const std::vector<ScanRecord>& records) {
  StepChecker steps;
  std::uint32_t segment = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    steps.add(pairs[i].truth, pairs[i].estimate, records[i].status.state,
              records[i].segment != segment);
    segment = records[i].segment;
  }
  return {{"wrong_steps", steps.counts().wrong},
          {"silent_steps", steps.counts().silent},
          {"false_alarms", steps.counts().false_alarms}};
}

std::string to_csv(const std::vector<ScanRecord>& records) {
  // Each step that any scan took has a column; a scan that did without it took no time.
  const json::Json steps = step_times(records);
  std::ostringstream text;
  text << "scan,stamp,wall_ms,cpu_ms,state,iterations,inlier_fraction,overlap,key_frame,rescued";
  for (const auto& step : steps.items()) text << ',' << column_name(step.key());
  text << '\n';
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ScanRecord& r = records[i];
    text << i << ',' << r.stamp << ',' << r.wall_ms << ',' << r.cpu_ms << ','
         << front_end::to_string(r.status.state) << ',' << r.status.iterations << ','
         << r.status.inlier_fraction << ',' << r.status.overlap << ',' << r.key_frame << ','
         << r.status.rescued;
    for (const auto& step : steps.items()) text << ',' << step_ms(r, step.key());
    text << '\n';
  }
  return text.str();
}

Trajectory trajectory_of(const std::vector<ScanRecord>& records) {
  Trajectory trajectory;
  for (const ScanRecord& record : records) {
    trajectory.poses.push_back({record.stamp, record.T_odom_base});
  }
  return trajectory;
}

}  // namespace lidar_mapping::campaign
