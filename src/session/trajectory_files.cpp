// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/session/trajectory_files.hpp"

#include <map>
#include <set>

#include "lidar_mapping/common/atomic_file.hpp"

namespace lidar_mapping::session {

namespace {

Pose gnss_pose(const GnssPosition& position, const Eigen::Quaterniond& optimized_rotation) {
  const Eigen::Quaterniond rotation = position.R_enu_base.value_or(optimized_rotation);
  return {rotation, position.p_enu_base(rotation)};
}

std::set<Stamp> stamps_of(const Trajectory& trajectory) {
  std::set<Stamp> stamps;
  for (const StampedPose& entry : trajectory.poses) stamps.insert(entry.stamp);
  return stamps;
}

Trajectory restricted_to(const Trajectory& trajectory, const std::set<Stamp>& stamps) {
  Trajectory result;
  for (const StampedPose& entry : trajectory.poses) {
    if (stamps.count(entry.stamp) > 0) result.poses.push_back(entry);
  }
  return result;
}

}  // namespace

KeyFrameTrajectories key_frame_trajectories(const Session& session, const KeyFramePoses& poses,
                                            const std::vector<GnssPosition>& gnss) {
  KeyFrameTrajectories result;
  for (const KeyFrame& key_frame : session.key_frames()) {
    result.laser_odom.poses.push_back({key_frame.stamp, key_frame.T_odom_base});
  }
  std::map<Stamp, GnssPosition> positions;
  for (const GnssPosition& position : gnss) positions[position.stamp] = position;
  for (const KeyFramePose& pose : poses.poses) {
    result.optimized.poses.push_back({pose.stamp, pose.T_map_base});
    const auto position = positions.find(pose.stamp);
    if (position == positions.end()) continue;
    result.gnss.poses.push_back(
        {pose.stamp, gnss_pose(position->second, pose.T_map_base.rotation)});
  }
  // Merged drives may overlap in time.
  for (Trajectory* trajectory : {&result.laser_odom, &result.optimized, &result.gnss}) {
    sort_by_stamp(*trajectory);
  }
  return result;
}

void write_trajectories(const Session& session, const KeyFramePoses& poses,
                        const std::vector<GnssPosition>& gnss,
                        const std::filesystem::path& directory) {
  const KeyFrameTrajectories all = key_frame_trajectories(session, poses, gnss);
  const bool has_gnss = !all.gnss.poses.empty();
  const std::set<Stamp> common = stamps_of(has_gnss ? all.gnss : all.optimized);
  const auto write = [&](const std::string& name, const Trajectory& trajectory) {
    write_text_atomically(directory / (name + ".tum"), to_tum(trajectory));
    write_text_atomically(directory / (name + ".txt"), to_kitti(restricted_to(trajectory, common)));
  };
  write("laser_odom", all.laser_odom);
  write("optimized", all.optimized);
  if (has_gnss) {
    write("ground_truth", all.gnss);
    write("gnss", all.gnss);
  }
  Trajectory scans;
  for (const ScanOdometry& scan : session.odometry()) {
    scans.poses.push_back({scan.stamp, scan.T_odom_base});
  }
  write_text_atomically(directory / "laser_odom_scans.tum", to_tum(scans));
}

}  // namespace lidar_mapping::session
