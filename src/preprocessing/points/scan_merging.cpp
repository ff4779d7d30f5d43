// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/scan_merging.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::preprocessing {

namespace {

/// Largest number of waiting scans of another LiDAR. Chosen: 5 s at 10 Hz; bounds the memory where
/// the main LiDAR is silent.
constexpr std::size_t kMostOthers = 50;
/// s within which a time counts as that of the scan's first or last point. Chosen: times are
/// rounded by less, and columns are farther apart.
constexpr double kRounding = 1e-6;

}  // namespace

std::size_t append_points(RawScan& scan, const RawScan& other, const Pose& T_scan_other,
                          const PassLimits& limits) {
  scan.unpack();
  if (!scan.cloud.has_times() || !other.cloud.has_times()) return 0;
  scan.take_fingerprint();
  const TimeSpan span = scan.time_span ? *scan.time_span : time_span(scan.cloud);
  scan.time_span = span;  // the appended points are within
  const double delay = to_seconds(other.stamp - scan.stamp);
  const Eigen::Matrix3f R = T_scan_other.rotation_matrix().cast<float>();
  const Eigen::Vector3f t = T_scan_other.translation.cast<float>();
  std::size_t appended = 0;
  for (std::size_t i = 0; i < other.cloud.size(); ++i) {
    const double time = delay + static_cast<double>(other.cloud.times[i]);
    if (!(time >= span.begin - kRounding && time <= span.end + kRounding))
      continue;  // or not a number
    const Point& point = other.cloud.points[i];
    if (limits.is_out_of_range(point)) continue;
    const Eigen::Vector3f p = R * point.position() + t;
    scan.cloud.points.push_back({p.x(), p.y(), p.z(), point.intensity});
    scan.cloud.times.push_back(static_cast<float>(std::clamp(time, span.begin, span.end)));
    ++appended;
  }
  return appended;
}

void ScanMerger::add_other(RawScan scan, const Pose& T_base_other) {
  std::deque<PlacedScan>& scans = others_[scan.frame_id];
  // The stamps of a LiDAR rise. Where they do not, time has gone back, or a stamp was wrong.
  while (!scans.empty() && scans.back().scan.stamp >= scan.stamp) scans.pop_back();
  scans.push_back({std::move(scan), T_base_other});
  if (scans.size() > kMostOthers) scans.pop_front();
}

/// Whether another LiDAR has sent a scan that may have points of this one's time.
bool ScanMerger::is_accompanied(Stamp scan) const {
  for (const auto& [frame, scans] : others_) {
    if (!scans.empty() && scans.back().scan.stamp >= scan - reach_) return true;
  }
  return false;
}

std::vector<RawScan> ScanMerger::add(RawScan scan, const Pose& T_base_scan) {
  std::vector<RawScan> complete;
  if (auto before = flush()) complete.push_back(std::move(*before));
  if (is_accompanied(scan.stamp)) {
    held_ = PlacedScan{std::move(scan), T_base_scan};
  } else {
    complete.push_back(std::move(scan));
  }
  return complete;
}

std::optional<RawScan> ScanMerger::flush() {
  std::optional<PlacedScan> held = std::exchange(held_, std::nullopt);
  if (!held) return std::nullopt;
  const Stamp stamp = held->scan.stamp;
  const Pose T_scan_base = held->T_base_scan.inverse();
  for (auto& [frame, scans] : others_) {
    while (!scans.empty() && scans.front().scan.stamp < stamp - reach_) scans.pop_front();
    for (const PlacedScan& other : scans) {
      if (other.scan.stamp > stamp + reach_) break;
      append_points(held->scan, other.scan, T_scan_base * other.T_base_scan, limits_);
    }
  }
  return std::move(held->scan);
}

}  // namespace lidar_mapping::preprocessing
