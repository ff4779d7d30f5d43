// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/scan_track.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace lidar_mapping::pipeline {

namespace {

constexpr Stamp kGap = from_seconds(0.5);  // scans further apart say nothing of the motion between

using StampedPoses = std::vector<std::pair<Stamp, Pose>>;

/// What a key frame tells of the scans around it.
struct Correction {
  Stamp stamp;
  std::uint32_t segment;
  Pose T_map_odom;
};

/// By stamp.
std::vector<Correction> corrections(const session::Session& session, const KeyFramePoses& poses) {
  std::vector<Correction> result;
  const std::vector<KeyFrame> key_frames = session.key_frames();
  auto pose = poses.poses.begin();
  for (const KeyFrame& key_frame : key_frames) {
    while (pose != poses.poses.end() && pose->index < key_frame.index) ++pose;
    if (pose == poses.poses.end()) break;
    if (pose->index != key_frame.index) continue;
    result.push_back(
        {key_frame.stamp, key_frame.segment, pose->T_map_base * key_frame.T_odom_base.inverse()});
  }
  return result;
}

std::optional<Pose> placed(Stamp stamp, const Pose& T_odom_base,
                           const std::vector<Correction>& corrections) {
  if (corrections.empty()) return std::nullopt;
  const auto after = std::upper_bound(
      corrections.begin(), corrections.end(), stamp,
      [](Stamp wanted, const Correction& correction) { return wanted < correction.stamp; });
  if (after == corrections.begin()) return after->T_map_odom * T_odom_base;
  const Correction& before = *(after - 1);
  const Pose from_before = before.T_map_odom * T_odom_base;
  if (before.stamp == stamp || after == corrections.end()) return from_before;
  if (before.segment != after->segment) return std::nullopt;
  const double share = to_seconds(stamp - before.stamp) / to_seconds(after->stamp - before.stamp);
  return interpolate(from_before, after->T_map_odom * T_odom_base, share);
}

/// From the i-th to another scan per second; none where that is too long before or after.
std::optional<Vector6d> motion_to(const StampedPoses& odometry, std::size_t i, std::size_t other) {
  if (other >= odometry.size()) return std::nullopt;  // also before the first one
  const Stamp between = odometry[other].first - odometry[i].first;
  if (std::abs(between) > kGap) return std::nullopt;
  return Vector6d(difference(odometry[i].second, odometry[other].second) / to_seconds(between));
}

/// A chord from the i-th scan on to where it is `seconds` later is half a bend off its tangent.
Vector6d tangent(const Vector6d& chord, double seconds) {
  Vector6d twist = chord;
  twist.head<3>() -= 0.5 * seconds * chord.tail<3>().cross(chord.head<3>());
  return twist;
}

void add_motion(const StampedPoses& odometry, std::size_t i, PlacedScan& scan) {
  const auto after = motion_to(odometry, i, i + 1);
  const auto before = motion_to(odometry, i, i - 1);
  const double to_next = after ? to_seconds(odometry[i + 1].first - scan.stamp) : 0.0;
  const double to_last = before ? to_seconds(odometry[i - 1].first - scan.stamp) : 0.0;
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

}  // namespace

std::vector<PlacedScan> placed_scans(const session::Session& session, const KeyFramePoses& poses) {
  std::set<Stamp> lost;
  std::map<Stamp, double> elevation_shifts;
  for (const session::ScanRecord& scan : session.scans()) {
    if (scan.state == "lost" || scan.state == "repeated") lost.insert(scan.stamp);
    if (scan.elevation_shift != 0.0) elevation_shifts[scan.stamp] = scan.elevation_shift;
  }
  StampedPoses odometry = session.odometry();
  odometry.erase(std::remove_if(odometry.begin(), odometry.end(),
                                [&](const auto& pose) { return lost.count(pose.first) > 0; }),
                 odometry.end());
  const std::vector<Correction> known = corrections(session, poses);
  std::vector<PlacedScan> scans;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const auto T_map_base = placed(odometry[i].first, odometry[i].second, known);
    if (!T_map_base) continue;
    PlacedScan scan;
    scan.stamp = odometry[i].first;
    scan.T_map_base = *T_map_base;
    const auto shift = elevation_shifts.find(scan.stamp);
    if (shift != elevation_shifts.end()) scan.elevation_shift = shift->second;
    add_motion(odometry, i, scan);
    scans.push_back(scan);
  }
  return scans;
}

}  // namespace lidar_mapping::pipeline
