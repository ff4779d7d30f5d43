// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_drives.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace lidar_mapping::pipeline {

namespace {

/// Not always that of the first key frame: drives of older sessions were merged in any order.
Stamp begin_of(const SessionDrive& drive) {
  Stamp begin = std::numeric_limits<Stamp>::max();
  if (!drive.odometry.empty()) begin = drive.odometry.front().stamp;
  for (const KeyFrame& key_frame : drive.key_frames) begin = std::min(begin, key_frame.stamp);
  return begin;
}

}  // namespace

std::vector<SessionDrive> drives_of(const session::Session& session) {
  std::map<std::uint32_t, SessionDrive> with_odometry;
  std::map<Stamp, std::uint32_t> drive_at;
  for (const session::ScanOdometry& scan : session.odometry()) {
    with_odometry[scan.drive].odometry.push_back(scan);
    drive_at.emplace(scan.stamp, scan.drive);
  }
  const std::vector<KeyFrame> key_frames = session.key_frames();
  std::map<std::uint32_t, std::uint32_t> drive_of_segment;
  for (const KeyFrame& key_frame : key_frames) {
    const auto found = drive_at.find(key_frame.stamp);
    if (found != drive_at.end()) drive_of_segment.emplace(key_frame.segment, found->second);
  }
  std::map<std::uint32_t, SessionDrive> without_odometry;
  for (const KeyFrame& key_frame : key_frames) {
    const auto drive = drive_of_segment.find(key_frame.segment);
    SessionDrive& owner = drive != drive_of_segment.end() ? with_odometry[drive->second]
                                                          : without_odometry[key_frame.segment];
    owner.key_frames.push_back(key_frame);
  }
  std::vector<SessionDrive> drives;
  for (auto& [number, drive] : with_odometry) drives.push_back(std::move(drive));
  for (auto& [segment, drive] : without_odometry) drives.push_back(std::move(drive));
  std::stable_sort(drives.begin(), drives.end(), [](const SessionDrive& a, const SessionDrive& b) {
    return begin_of(a) < begin_of(b);
  });
  return drives;
}

}  // namespace lidar_mapping::pipeline
