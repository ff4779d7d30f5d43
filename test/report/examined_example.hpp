// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "examined_drive.hpp"
#include "localization_record.hpp"

namespace lidar_mapping::report {

constexpr Stamp kMonday = from_seconds(1'600'000'000.0);
constexpr Stamp kTuesday = kMonday + 86'400 * kNanosecondsPerSecond;

/// 30 key frames along x, 2 m apart from 0 to 58 m: three sections of ten.
inline KeyFramePoses straight_map() {
  KeyFramePoses map;
  for (KeyFrameIndex i = 0; i < 30; ++i) {
    Pose T_map_base;
    T_map_base.translation.x() = 2.0 * i;
    map.poses.push_back({i, kMonday + i * kNanosecondsPerSecond, T_map_base});
  }
  return map;
}

/// Odometry begins elsewhere and heads elsewhere.
inline Pose T_odom_map() { return {exp_so3({0.0, 0.0, 1.2}), {100.0, 50.0, 3.0}}; }

/// Another day, 1 m beside that way, a scan for each metre from x = 0 on and ten in a second. It is
/// searched for over five scans, then followed.
inline ExaminedDrive straight_drive(std::size_t scans = 60) {
  ExaminedDrive drive{"tuesday_in_monday", {"tuesday.bag"}, {}};
  for (std::size_t i = 0; i < scans; ++i) {
    ExaminedScan scan;
    scan.stamp = kTuesday + static_cast<Stamp>(i) * (kNanosecondsPerSecond / 10);
    scan.path = static_cast<double>(i);
    scan.T_map_base.translation = {scan.path, 1.0, 0.0};
    scan.T_odom_base = T_odom_map() * scan.T_map_base;
    scan.agreement = 0.8;
    scan.coverage = 0.9;
    scan.reason = "80 % of the surroundings agree with the map";
    if (i >= 5) scan.state = localization::LocalizationState::kFollowing;
    drive.scans.push_back(scan);
  }
  return drive;
}

/// Gives scans from `begin` to before `end` a state. Without a pose they have none of the drive.
inline void set_state(ExaminedDrive& drive, std::size_t begin, std::size_t end,
                      localization::LocalizationState state) {
  for (std::size_t i = begin; i < end; ++i) {
    drive.scans[i].state = state;
    if (!has_pose(state)) drive.scans[i].T_map_base = Pose::Identity();
  }
}

/// localization.csv, as localize_bag writes it.
inline std::string table_of(const std::vector<ExaminedScan>& scans) {
  std::string text =
      "stamp,state,probability,x,y,z,qx,qy,qz,qw,stddev_x,stddev_y,stddev_z,stddev_roll_deg,"
      "stddev_pitch_deg,stddev_yaw_deg,agreement,coverage,hypotheses,path,segment,reason\n";
  for (const ExaminedScan& scan : scans) {
    const Eigen::Vector3d& p = scan.T_map_base.translation;
    const Eigen::Quaterniond& q = scan.T_map_base.rotation;
    text += seconds_text(scan.stamp) + "," + to_string(scan.state) + ",0.9990";
    text += !has_pose(scan.state)
                ? ",,,,,,,,,,,,,"
                : formatted(",%.4f,%.4f,%.4f,%.9f,%.9f,%.9f,%.9f,0.01,0.01,0.01,0.1,0.1,0.1", p.x(),
                            p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    text += formatted(",%.4f,%.4f,1,%.4f,%u,\"", scan.agreement, scan.coverage, scan.path,
                      scan.segment) +
            scan.reason + "\"\n";
  }
  return text;
}

inline std::string odometry_of(const std::vector<ExaminedScan>& scans) {
  Trajectory odometry;
  for (const ExaminedScan& scan : scans) odometry.poses.push_back({scan.stamp, scan.T_odom_base});
  return to_tum(odometry);
}

/// The folder of localize_bag for a drive in a map.
inline void write_drive(const std::filesystem::path& folder, const ExaminedDrive& drive,
                        const KeyFramePoses& map) {
  std::filesystem::create_directories(folder / "trajectory");
  std::ofstream(folder / "localization.csv") << table_of(drive.scans);
  std::ofstream(folder / "trajectory/laser_odom_scans.tum") << odometry_of(drive.scans);
  write_localization_record(folder, {drive.recordings, identity_of(map, "monday")});
}

}  // namespace lidar_mapping::report
