#include "lidar_mapping/session/trajectory_files.hpp"

#include <algorithm>
#include <iomanip>
#include <set>
#include <sstream>

#include "lidar_mapping/common/atomic_file.hpp"

namespace lidar_mapping::session {

namespace {

Pose gnss_pose(const GnssPosition& position, const Eigen::Quaterniond& optimized_rotation) {
  const Eigen::Quaterniond rotation = position.R_enu_base.value_or(optimized_rotation);
  return {rotation, position.p_enu_antenna - rotation * position.p_base_antenna};
}

std::set<Stamp> stamps_of(const Trajectory& trajectory) {
  std::set<Stamp> stamps;
  for (const StampedPose& entry : trajectory.poses) stamps.insert(entry.stamp);
  return stamps;
}

Trajectory restricted(const Trajectory& trajectory, const std::set<Stamp>& stamps) {
  Trajectory result;
  for (const StampedPose& entry : trajectory.poses) {
    if (stamps.count(entry.stamp) > 0) result.poses.push_back(entry);
  }
  return result;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

}  // namespace

KeyFrameTrajectories key_frame_trajectories(const Session& session, const KeyFramePoses& poses) {
  KeyFrameTrajectories result;
  for (const KeyFrame& key_frame : session.key_frames()) {
    result.laser_odom.poses.push_back({key_frame.stamp, key_frame.T_odom_base});
  }
  std::map<Stamp, GnssPosition> positions;
  for (const GnssPosition& position : session.gnss()) positions[position.stamp] = position;
  for (const KeyFramePose& pose : poses.poses) {
    result.optimized.poses.push_back({pose.stamp, pose.T_map_base});
    const auto position = positions.find(pose.stamp);
    if (position == positions.end()) continue;
    result.gnss.poses.push_back(
        {pose.stamp, gnss_pose(position->second, pose.T_map_base.rotation)});
  }
  return result;
}

void write_trajectories(const Session& session, const KeyFramePoses& poses,
                        const std::filesystem::path& directory) {
  const KeyFrameTrajectories all = key_frame_trajectories(session, poses);
  const bool has_gnss = !all.gnss.poses.empty();
  const std::set<Stamp> common = stamps_of(has_gnss ? all.gnss : all.optimized);
  const auto write = [&](const std::string& name, const Trajectory& trajectory) {
    write_text_atomically(directory / (name + ".tum"), to_tum(trajectory));
    write_text_atomically(directory / (name + ".txt"), to_kitti(restricted(trajectory, common)));
  };
  write("laser_odom", all.laser_odom);
  write("optimized", all.optimized);
  if (has_gnss) {
    write("ground_truth", all.gnss);
    write("gnss", all.gnss);
  }
  Trajectory scans;
  for (const auto& [stamp, pose] : session.odometry()) scans.poses.push_back({stamp, pose});
  write_text_atomically(directory / "laser_odom_scans.tum", to_tum(scans));
}

void write_loops_csv(const Session& session, const std::filesystem::path& path) {
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> verdicts;
  for (const LoopVerdict& verdict : session.verdicts()) {
    verdicts[{verdict.from, verdict.to}] = verdict;
  }
  std::ostringstream text;
  text << std::setprecision(12)
       << "from,to,stamp_ns,x,y,z,qx,qy,qz,qw,fitness,overlap,source,verdict,reason\n";
  for (const Loop& loop : session.loops()) {
    const Eigen::Vector3d& t = loop.T_from_to.translation;
    const Eigen::Quaterniond& q = loop.T_from_to.rotation;
    const auto found = verdicts.find({loop.from, loop.to});
    const LoopVerdict verdict = found == verdicts.end() ? LoopVerdict{} : found->second;
    text << loop.from << ',' << loop.to << ',' << loop.stamp << ',' << t.x() << ',' << t.y() << ','
         << t.z() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w() << ','
         << loop.fitness << ',' << loop.overlap << ',' << to_string(loop.source) << ','
         << to_string(verdict.verdict) << ',' << quoted(verdict.reason) << '\n';
  }
  write_text_atomically(path, text.str());
}

}  // namespace lidar_mapping::session
