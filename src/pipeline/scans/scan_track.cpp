// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/scan_track.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "lidar_mapping/pipeline/session_drives.hpp"

namespace lidar_mapping::pipeline {

namespace {

// scans further apart do not determine the motion between them
constexpr Stamp kMaxGap = from_seconds(0.5);

using Odometry = std::vector<session::ScanOdometry>;

/// Correction that a key frame gives for the scans around it.
struct Correction {
  Stamp stamp;
  std::uint32_t segment;
  Pose T_map_odom;
};

/// Corrections of all key frames of a drive with a pose, by stamp.
struct Corrections {
  std::vector<Correction> list;
  /// Whether the first and the last key frame of the drive are among them. Otherwise the scans
  /// before or behind these are not wanted, or nobody knows where they are.
  bool has_first = false;
  bool has_last = false;
};

Corrections corrections(const std::vector<KeyFrame>& key_frames, const KeyFramePoses& poses) {
  Corrections corrections;
  std::vector<Correction>& result = corrections.list;
  auto pose = poses.poses.begin();
  for (const KeyFrame& key_frame : key_frames) {
    while (pose != poses.poses.end() && pose->index < key_frame.index) ++pose;
    if (pose == poses.poses.end()) break;
    if (pose->index != key_frame.index) continue;
    result.push_back(
        {key_frame.stamp, key_frame.segment, pose->T_map_base * key_frame.T_odom_base.inverse()});
  }
  // Older sessions do not tell drives apart that were merged in another order than that of their
  // times.
  std::stable_sort(result.begin(), result.end(),
                   [](const Correction& a, const Correction& b) { return a.stamp < b.stamp; });
  if (result.empty()) return corrections;
  const auto [first, last] =
      std::minmax_element(key_frames.begin(), key_frames.end(),
                          [](const KeyFrame& a, const KeyFrame& b) { return a.stamp < b.stamp; });
  corrections.has_first = result.front().stamp == first->stamp;
  corrections.has_last = result.back().stamp == last->stamp;
  return corrections;
}

std::optional<Pose> corrected_pose(Stamp stamp, const Pose& T_odom_base,
                                   const Corrections& corrections) {
  const std::vector<Correction>& list = corrections.list;
  if (list.empty()) return std::nullopt;
  const auto after = std::upper_bound(
      list.begin(), list.end(), stamp,
      [](Stamp wanted, const Correction& correction) { return wanted < correction.stamp; });
  if (after == list.begin()) {
    if (!corrections.has_first) return std::nullopt;
    return after->T_map_odom * T_odom_base;
  }
  const Correction& before = *(after - 1);
  const Pose from_before = before.T_map_odom * T_odom_base;
  if (before.stamp == stamp) return from_before;
  if (after == list.end()) {
    if (!corrections.has_last) return std::nullopt;
    return from_before;
  }
  if (before.segment != after->segment) return std::nullopt;
  const double fraction =
      to_seconds(stamp - before.stamp) / to_seconds(after->stamp - before.stamp);
  return interpolate(from_before, after->T_map_odom * T_odom_base, fraction);
}

/// Motion from the i-th to another scan per second; none if the other one is too far away in time.
std::optional<Vector6d> motion_to(const Odometry& odometry, std::size_t i, std::size_t other) {
  if (other >= odometry.size()) return std::nullopt;  // i - 1 of the first scan wraps
  const Stamp between = odometry[other].stamp - odometry[i].stamp;
  if (std::abs(between) > kMaxGap) return std::nullopt;
  const Pose& from = odometry[i].T_odom_base;
  return Vector6d(difference(from, odometry[other].T_odom_base) / to_seconds(between));
}

/// Tangent of the path at the beginning of a chord that lasts `seconds`: the chord deviates from it
/// by half of the rotation.
Vector6d tangent(const Vector6d& chord, double seconds) {
  Vector6d twist = chord;
  twist.head<3>() -= 0.5 * seconds * chord.tail<3>().cross(chord.head<3>());
  return twist;
}

void add_motion(const Odometry& odometry, std::size_t i, ScanPose& scan) {
  const auto after = motion_to(odometry, i, i + 1);
  const auto before = motion_to(odometry, i, i - 1);
  const double to_next = after ? to_seconds(odometry[i + 1].stamp - scan.stamp) : 0.0;
  const double to_last = before ? to_seconds(odometry[i - 1].stamp - scan.stamp) : 0.0;
  if (after && before) {
    const double whole = to_next - to_last;
    scan.twist = (*after * -to_last + *before * to_next) / whole;
    scan.acceleration = 2.0 * (*after - *before) / whole;
    scan.acceleration.head<3>() -= scan.twist.tail<3>().cross(scan.twist.head<3>());
  } else if (after) {
    scan.twist = tangent(*after, to_next);
  } else if (before) {
    scan.twist = tangent(*before, to_last);
  }
}

/// The scans of a drive that were neither lost nor repeated.
Odometry tracked(Odometry odometry, const std::set<Stamp>& lost) {
  odometry.erase(std::remove_if(odometry.begin(), odometry.end(),
                                [&](const auto& scan) { return lost.count(scan.stamp) > 0; }),
                 odometry.end());
  return odometry;
}

}  // namespace

std::vector<ScanPose> scan_poses(const session::Session& session, const KeyFramePoses& poses) {
  std::set<Stamp> lost;
  std::map<Stamp, double> elevation_shifts;
  for (const session::ScanRecord& scan : session.scans()) {
    if (scan.state == "lost" || scan.state == "repeated") lost.insert(scan.stamp);
    if (scan.elevation_shift != 0.0) elevation_shifts[scan.stamp] = scan.elevation_shift;
  }
  std::vector<ScanPose> scans;
  for (const SessionDrive& drive : drives_of(session)) {
    const Odometry odometry = tracked(drive.odometry, lost);
    const Corrections known = corrections(drive.key_frames, poses);
    for (std::size_t i = 0; i < odometry.size(); ++i) {
      const auto T_map_base = corrected_pose(odometry[i].stamp, odometry[i].T_odom_base, known);
      if (!T_map_base) continue;
      ScanPose scan;
      scan.stamp = odometry[i].stamp;
      scan.T_map_base = *T_map_base;
      const auto shift = elevation_shifts.find(scan.stamp);
      if (shift != elevation_shifts.end()) scan.elevation_shift = shift->second;
      add_motion(odometry, i, scan);
      scans.push_back(scan);
    }
  }
  std::stable_sort(scans.begin(), scans.end(),
                   [](const ScanPose& a, const ScanPose& b) { return a.stamp < b.stamp; });
  return scans;
}

}  // namespace lidar_mapping::pipeline
