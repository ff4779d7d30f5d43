// SPDX-License-Identifier: BSD-3-Clause
#include "report_figures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/path_length.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/pipeline/session_drives.hpp"

namespace lidar_mapping::report {

namespace {

constexpr double kRelativeDelta = 10.0;  // m, of the relative pose error; chosen: some key frames
constexpr std::size_t kFewestPairs = 3;  // by geometry, for an alignment

/// Sections of consecutive scans that were not tracked.
json::Json untracked_sections(const std::vector<session::ScanRecord>& scans) {
  json::Json found = json::Json::array();
  std::string state = "tracking";
  for (const session::ScanRecord& scan : scans) {
    if (scan.state != "tracking" && scan.state == state) {
      found.back()["scans"] = found.back()["scans"].get<int>() + 1;
    } else if (scan.state != "tracking") {
      found.push_back({{"state", scan.state},
                       {"begin_s", to_seconds(scan.stamp - scans.front().stamp)},
                       {"scans", 1}});
    }
    state = scan.state;
  }
  return found;
}

/// The number of the drive of each pose.
std::vector<std::size_t> drive_numbers(const session::Session& session,
                                       const KeyFramePoses& poses) {
  const std::vector<pipeline::SessionDrive> drives = pipeline::drives_of(session);
  std::map<KeyFrameIndex, std::size_t> drive_of;
  for (std::size_t drive = 0; drive < drives.size(); ++drive) {
    for (const KeyFrame& key_frame : drives[drive].key_frames) drive_of[key_frame.index] = drive;
  }
  std::vector<std::size_t> numbers;
  for (const KeyFramePose& pose : poses.poses) numbers.push_back(drive_of.at(pose.index));
  return numbers;
}

/// Length of the path up to each pose, m. Between the vehicles of two drives there is none.
std::vector<double> distances_of(const KeyFramePoses& poses,
                                 const std::vector<std::size_t>& drives) {
  return travelled_distances(
      poses.poses.size(),
      [&](std::size_t i) -> const auto& { return poses.poses[i].T_map_base.translation; },
      [&](std::size_t i) { return drives[i] != drives[i - 1]; });
}

/// Time on the way, s: that of all drives together.
double seconds_of(const ReportInput& input) {
  std::map<std::size_t, std::pair<Stamp, Stamp>> times;  // first and last of each drive
  for (std::size_t i = 0; i < input.drives.size(); ++i) {
    const Stamp stamp = input.poses.poses[i].stamp;
    auto& [first, last] = times.try_emplace(input.drives[i], stamp, stamp).first->second;
    first = std::min(first, stamp);
    last = std::max(last, stamp);
  }
  Stamp sum = 0;
  for (const auto& [drive, time] : times) sum += time.second - time.first;
  return to_seconds(sum);
}

Trajectory trajectory_of(const KeyFramePoses& poses) {
  Trajectory trajectory;
  for (const KeyFramePose& pose : poses.poses) {
    trajectory.poses.push_back({pose.stamp, pose.T_map_base});
  }
  return trajectory;
}

/// Pairs of poses and truth, after rigid alignment.
std::vector<evaluation::PosePair> aligned_pairs(const Trajectory& truth,
                                                const KeyFramePoses& poses) {
  const Trajectory estimate = trajectory_of(poses);
  const auto pairs = evaluation::associate(truth, estimate);
  if (pairs.size() < kFewestPairs) {
    const evaluation::LeftOut left_out = evaluation::left_out(truth, estimate);
    throw InputError("only " + std::to_string(pairs.size()) + " of " +
                     std::to_string(estimate.poses.size()) + " key frames have a true pose; " +
                     evaluation::reason_of(left_out, "the true trajectory") + "; " +
                     evaluation::remedy_for(left_out));
  }
  return evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));
}

}  // namespace

ReportInput report_input(const session::Session& session, std::optional<Trajectory> truth) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  KeyFramePoses poses = track.poses();
  std::vector<std::size_t> drives = drive_numbers(session, poses);
  std::vector<double> distances = distances_of(poses, drives);
  return {session,           std::move(poses),     track.odometry(),
          std::move(drives), std::move(distances), std::move(truth)};
}

json::Json drive_figures(const ReportInput& input) {
  json::Json figures = {{"key_frames", input.poses.poses.size()},
                        {"length_m", input.distances.empty() ? 0.0 : input.distances.back()},
                        {"seconds", seconds_of(input)},
                        {"revision", input.poses.revision},
                        {"datum", nullptr}};
  if (const auto datum = input.session.datum()) {
    figures["datum"] = {datum->latitude_deg, datum->longitude_deg, datum->altitude_m};
  }
  return figures;
}

json::Json trajectory_figures(const ReportInput& input) {
  json::Json rows = json::Json::array();
  double farthest = 0.0;
  double vertical = 0.0;
  for (std::size_t i = 0; i < input.distances.size(); ++i) {
    const Pose& map_pose = input.poses.poses[i].T_map_base;
    const Pose& odometry = input.odometry.poses[i].T_map_base;
    const Eigen::Vector3d& p = map_pose.translation;
    const Eigen::Vector3d& q = odometry.translation;
    const double turned = yaw_of(odometry.rotation * map_pose.rotation.conjugate()) * kDegPerRad;
    rows.push_back({input.poses.poses[i].index, input.distances[i], p.x(), p.y(), p.z(), q.x(),
                    q.y(), q.z(), turned});
    farthest = std::max(farthest, (q - p).norm());
    vertical = std::max(vertical, std::abs(q.z() - p.z()));
  }
  return {{"columns",
           {"key_frame", "distance", "x", "y", "z", "odometry_x", "odometry_y", "odometry_z",
            "odometry_yaw_deg"}},
          {"rows", rows},
          {"odometry_max_m", farthest},
          {"odometry_max_vertical_m", vertical}};
}

json::Json scan_figures(const ReportInput& input) {
  const auto scans = input.session.scans();
  std::map<std::string, int> states;
  std::vector<double> seconds;
  std::int64_t dropped = 0;
  for (const session::ScanRecord& scan : scans) {
    ++states[scan.state];
    seconds.push_back(scan.seconds);
    // The count begins at 0 again after a restart, and in each of merged drives.
    dropped = std::max(dropped, scan.scans_dropped);
  }
  double optimising = 0.0;
  double longest = 0.0;
  const auto revisions = input.session.revisions();
  for (const session::RevisionRecord& revision : revisions) {
    optimising += revision.seconds;
    longest = std::max(longest, revision.seconds);
  }
  return {{"scans", scans.size()},
          {"dropped", dropped},
          {"states", states},
          {"sections", untracked_sections(scans)},
          {"front_end_median_s", quantile(seconds, 0.5)},
          {"front_end_p99_s", quantile(seconds, 0.99)},
          {"optimisations", revisions.size()},
          {"optimisation_longest_s", longest},
          {"optimisation_total_s", optimising}};
}

json::Json truth_figures(const ReportInput& input) {
  if (!input.truth) return nullptr;
  const Trajectory& truth = *input.truth;
  const auto pairs = aligned_pairs(truth, input.poses);
  const auto of_odometry = aligned_pairs(truth, input.odometry);
  const auto ape = evaluation::absolute_pose_error(pairs);
  const auto rpe = evaluation::relative_pose_error(pairs, kRelativeDelta);
  const auto kitti = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  const auto left_out = evaluation::left_out(truth, trajectory_of(input.poses));
  const auto over = [](std::size_t count, double figure) {
    return count == 0 ? json::Json() : json::Json(figure);
  };
  const auto distances = evaluation::travelled_distances(pairs);
  json::Json rows = json::Json::array();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pose error = pairs[i].truth.inverse() * pairs[i].estimate;
    const Pose before = of_odometry[i].truth.inverse() * of_odometry[i].estimate;
    rows.push_back({distances[i], error.translation.norm(),
                    rotation_angle(error.rotation) * kDegPerRad, before.translation.norm()});
  }
  return {{"poses", pairs.size()},
          {"left_out", {{"outside", left_out.outside}, {"in_gaps", left_out.in_gaps}}},
          {"ape_rmse_m", ape.translation_m.rmse},
          {"ape_max_m", ape.translation_m.max},
          {"ape_rmse_deg", ape.rotation_deg.rmse},
          {"rpe_delta_m", kRelativeDelta},
          {"rpe_count", rpe.translation_m.count},
          {"rpe_rmse_m", over(rpe.translation_m.count, rpe.translation_m.rmse)},
          {"rpe_rmse_deg", over(rpe.rotation_deg.count, rpe.rotation_deg.rmse)},
          {"kitti_segments", kitti.segments},
          {"kitti_translation_percent", over(kitti.segments, kitti.translation_percent)},
          {"kitti_rotation_deg_per_100m", over(kitti.segments, kitti.rotation_deg_per_100m)},
          {"columns", {"distance", "error_m", "error_deg", "odometry_error_m"}},
          {"rows", rows}};
}

json::Json to_json(const map_quality::LocalThickness& thickness, bool has_ratio) {
  // Without the position of the sensor the angles of incidence are unknown, so there is no ratio.
  const auto part = [&](const map_quality::Thickness& of) -> json::Json {
    return {{"cells", of.cells},
            {"median_m", of.median},
            {"p90_m", of.percentile_90},
            {"median_within_m", of.median_within},
            {"median_ratio_to_noise", has_ratio ? json::Json(of.median_ratio) : json::Json()}};
  };
  return {{"ground", part(thickness.ground)},
          {"walls", part(thickness.walls)},
          {"planar_fraction", thickness.planar_fraction}};
}

json::Json to_json(const map_quality::PassMisalignment& misalignment) {
  return {{"key_frame", misalignment.key_frame},
          {"position",
           {misalignment.position.x(), misalignment.position.y(), misalignment.position.z()}},
          {"along_m", misalignment.forward},
          {"left_m", misalignment.left},
          {"up_m", misalignment.up},
          {"yaw_deg", misalignment.yaw * kDegPerRad},
          {"size_m", misalignment.distance()},
          {"planes", misalignment.planes},
          {"residual_m", misalignment.residual}};
}

json::Json to_json(const map_quality::MapEntropy& entropy) {
  return {{"mean", entropy.mean},
          {"radius_m", entropy.radius},
          {"points", entropy.points},
          {"mean_neighbours", entropy.neighbours}};
}

}  // namespace lidar_mapping::report
