#include "report_figures.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

namespace lidar_mapping::tools {

namespace {

constexpr double kDegrees = 180.0 / M_PI;

using PoseOf = std::map<KeyFrameIndex, Pose>;

PoseOf by_index(const KeyFramePoses& poses) {
  PoseOf found;
  for (const KeyFramePose& pose : poses.poses) found[pose.index] = pose.T_map_base;
  return found;
}

std::vector<double> ways_of(const KeyFramePoses& poses) {
  std::vector<double> ways;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    const auto position = [&](std::size_t k) { return poses.poses[k].T_map_base.translation; };
    ways.push_back(i == 0 ? 0.0 : ways.back() + (position(i) - position(i - 1)).norm());
  }
  return ways;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// The newest verdict on a pair of key frames that is not about another candidate.
std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest_verdicts(
    const session::Session& session) {
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> newest;
  for (const LoopVerdict& verdict : session.verdicts()) {
    newest[{verdict.from, verdict.to}] = verdict;
  }
  return newest;
}

Json loop_row(const LoopVerdict& verdict) {
  return {{"from", verdict.from},
          {"to", verdict.to},
          {"source", to_string(verdict.source)},
          {"verdict", to_string(verdict.verdict)},
          {"reason", verdict.reason}};
}

/// Whether the graph put the map into East-North-Up.
bool is_in_enu(const session::Session& session) {
  const auto config = config::load<back_end::BackEndConfig>(
      {pipeline::stored_configuration<back_end::BackEndConfig>(session)});
  return config.use_gnss && session.datum().has_value();
}

/// Scans in a row that were not tracked.
Json stretches(const std::vector<session::ScanRecord>& scans) {
  Json found = Json::array();
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

/// Poses beside the truth, moved rigidly onto it.
std::vector<evaluation::PosePair> aligned_pairs(const Trajectory& truth,
                                                const KeyFramePoses& poses) {
  Trajectory estimate;
  for (const KeyFramePose& pose : poses.poses) {
    estimate.poses.push_back({pose.stamp, pose.T_map_base});
  }
  const auto pairs = evaluation::associate(truth, estimate);
  return evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));
}

}  // namespace

ReportInput report_input(const session::Session& session, const std::string& truth) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  return {session, track.poses(), track.odometry(), truth};
}

Json drive_figures(const ReportInput& input) {
  const auto& poses = input.poses.poses;
  const auto ways = ways_of(input.poses);
  Json figures = {
      {"key_frames", poses.size()},
      {"length_m", ways.empty() ? 0.0 : ways.back()},
      {"seconds", poses.empty() ? 0.0 : to_seconds(poses.back().stamp - poses.front().stamp)},
      {"revision", input.poses.revision},
      {"datum", nullptr}};
  if (const auto datum = input.session.datum()) {
    figures["datum"] = {datum->latitude_deg, datum->longitude_deg, datum->altitude_m};
  }
  return figures;
}

Json trajectory_figures(const ReportInput& input) {
  const auto ways = ways_of(input.poses);
  Json rows = Json::array();
  double farthest = 0.0;
  double vertical = 0.0;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Pose& map_pose = input.poses.poses[i].T_map_base;
    const Pose& odometry = input.odometry.poses[i].T_map_base;
    const Eigen::Vector3d& p = map_pose.translation;
    const Eigen::Vector3d& q = odometry.translation;
    const double turned = yaw_of(odometry.rotation * map_pose.rotation.conjugate()) * kDegrees;
    rows.push_back(
        {input.poses.poses[i].index, ways[i], p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), turned});
    farthest = std::max(farthest, (q - p).norm());
    vertical = std::max(vertical, std::abs(q.z() - p.z()));
  }
  return {{"columns",
           {"key_frame", "way", "x", "y", "z", "odometry_x", "odometry_y", "odometry_z",
            "odometry_yaw_deg"}},
          {"rows", rows},
          {"odometry_max_m", farthest},
          {"odometry_max_vertical_m", vertical}};
}

Json loop_figures(const ReportInput& input) {
  const PoseOf poses = by_index(input.poses);
  const PoseOf odometry = by_index(input.odometry);
  auto verdicts = newest_verdicts(input.session);
  Json rows = Json::array();
  std::vector<double> metres;
  std::vector<double> degrees;
  for (const Loop& loop : input.session.loops()) {
    const auto from = poses.find(loop.from);
    const auto to = poses.find(loop.to);
    if (from == poses.end() || to == poses.end()) continue;
    const Pose left_over = loop.T_from_to.inverse() * (from->second.inverse() * to->second);
    LoopVerdict verdict{loop.from, loop.to, loop.stamp, loop.source, Verdict::kAccepted,
                        "",        0.0,     0.0,        0.0,         0.0,
                        0.0,       0.0};
    const auto known = verdicts.find({loop.from, loop.to});
    if (known != verdicts.end()) {
      verdict = known->second;
      verdicts.erase(known);
    }
    Json row = loop_row(verdict);
    row["residual_m"] = left_over.translation.norm();
    row["odometry_residual_m"] =
        (loop.T_from_to.inverse() * (odometry.at(loop.from).inverse() * odometry.at(loop.to)))
            .translation.norm();
    row["residual_deg"] = rotation_angle(left_over.rotation) * kDegrees;
    if (verdict.verdict == Verdict::kAccepted) {
      metres.push_back(row["residual_m"]);
      degrees.push_back(row["residual_deg"]);
    }
    rows.push_back(row);
  }
  const std::size_t taken = metres.size();
  const std::size_t dropped = rows.size() - taken;
  for (const auto& [pair, verdict] : verdicts) rows.push_back(loop_row(verdict));
  return {{"used", taken},
          {"dropped_by_graph", dropped},
          {"refused_or_undecided", verdicts.size()},
          {"median_residual_m", quantile(metres, 0.5)},
          {"max_residual_m", quantile(metres, 1.0)},
          {"median_residual_deg", quantile(degrees, 0.5)},
          {"max_residual_deg", quantile(degrees, 1.0)},
          {"candidates", rows}};
}

Json gnss_figures(const ReportInput& input) {
  std::map<Stamp, std::size_t> at;
  for (std::size_t i = 0; i < input.poses.poses.size(); ++i) at[input.poses.poses[i].stamp] = i;
  std::vector<evaluation::PosePair> pairs;
  std::vector<double> sigmas;
  for (const GnssPosition& gnss : input.session.gnss()) {
    const auto found = at.find(gnss.stamp);
    if (found == at.end()) continue;
    const Pose& pose = input.poses.poses[found->second].T_map_base;
    evaluation::PosePair pair;
    pair.stamp = gnss.stamp;
    pair.truth.translation = gnss.p_enu_antenna;
    pair.estimate.translation = pose * gnss.p_base_antenna;
    pairs.push_back(pair);
    sigmas.push_back(std::sqrt(0.5 * gnss.covariance.topLeftCorner<2, 2>().trace()));
  }
  const bool in_enu = is_in_enu(input.session);
  if (!in_enu && pairs.size() >= 3) pairs = aligned(pairs, evaluation::rigid_alignment(pairs));
  const auto ways = ways_of(input.poses);
  Json rows = Json::array();
  std::vector<double> horizontal;
  std::vector<double> vertical;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d d = pairs[i].truth.translation - pairs[i].estimate.translation;
    rows.push_back({ways[at.at(pairs[i].stamp)], d.x(), d.y(), d.z(), sigmas[i],
                    pairs[i].truth.translation.x(), pairs[i].truth.translation.y()});
    horizontal.push_back(d.head<2>().norm());
    vertical.push_back(std::abs(d.z()));
  }
  return {{"positions", pairs.size()},
          {"used_by_graph", in_enu},
          {"median_horizontal_m", quantile(horizontal, 0.5)},
          {"p95_horizontal_m", quantile(horizontal, 0.95)},
          {"median_vertical_m", quantile(vertical, 0.5)},
          {"p95_vertical_m", quantile(vertical, 0.95)},
          {"median_stated_sigma_m", quantile(sigmas, 0.5)},
          {"columns", {"way", "east", "north", "up", "stated_sigma", "x", "y"}},
          {"rows", rows}};
}

Json scan_figures(const ReportInput& input) {
  const auto scans = input.session.scans();
  std::map<std::string, int> states;
  std::vector<double> seconds;
  for (const session::ScanRecord& scan : scans) {
    ++states[scan.state];
    seconds.push_back(scan.seconds);
  }
  double optimising = 0.0;
  double longest = 0.0;
  const auto revisions = input.session.revisions();
  for (const session::RevisionRecord& revision : revisions) {
    optimising += revision.seconds;
    longest = std::max(longest, revision.seconds);
  }
  return {{"scans", scans.size()},
          {"dropped", scans.empty() ? 0 : scans.back().scans_dropped},
          {"states", states},
          {"stretches", stretches(scans)},
          {"front_end_median_s", quantile(seconds, 0.5)},
          {"front_end_p99_s", quantile(seconds, 0.99)},
          {"optimisations", revisions.size()},
          {"optimisation_longest_s", longest},
          {"optimisation_total_s", optimising}};
}

Json truth_figures(const ReportInput& input) {
  if (input.truth.empty()) return nullptr;
  const Trajectory truth = read_trajectory(input.truth);
  const auto pairs = aligned_pairs(truth, input.poses);
  const auto of_odometry = aligned_pairs(truth, input.odometry);
  const auto ape = evaluation::absolute_pose_error(pairs);
  const auto rpe = evaluation::relative_pose_error(pairs, 10.0);
  const auto kitti = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  const auto ways = evaluation::travelled_distances(pairs);
  Json rows = Json::array();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pose error = pairs[i].truth.inverse() * pairs[i].estimate;
    const Pose before = of_odometry[i].truth.inverse() * of_odometry[i].estimate;
    rows.push_back({ways[i], error.translation.norm(), rotation_angle(error.rotation) * kDegrees,
                    before.translation.norm()});
  }
  return {{"poses", pairs.size()},
          {"ape_rmse_m", ape.translation_m.rmse},
          {"ape_max_m", ape.translation_m.max},
          {"ape_rmse_deg", ape.rotation_deg.rmse},
          {"rpe_10m_rmse_m", rpe.translation_m.rmse},
          {"rpe_10m_rmse_deg", rpe.rotation_deg.rmse},
          {"kitti_translation_percent", kitti.translation_percent},
          {"kitti_rotation_deg_per_100m", kitti.rotation_deg_per_100m},
          {"columns", {"way", "error_m", "error_deg", "odometry_error_m"}},
          {"rows", rows}};
}

namespace {

/// Without the place of the sensor nobody knows how beams met the surfaces: no ratio then.
Json thickness_json(const map::Thickness& thickness, bool has_ratio) {
  return {{"cells", thickness.cells},
          {"median_m", thickness.median},
          {"p90_m", thickness.high},
          {"median_within_m", thickness.median_within},
          {"median_ratio_to_noise", has_ratio ? Json(thickness.median_ratio) : Json()}};
}

}  // namespace

Json to_json(const map::LocalThickness& thickness, bool has_ratio) {
  return {{"ground", thickness_json(thickness.ground, has_ratio)},
          {"walls", thickness_json(thickness.walls, has_ratio)},
          {"planar_share", thickness.planar_share}};
}

Json to_json(const map::GhostVector& ghost) {
  return {{"key_frame", ghost.key_frame},
          {"position", {ghost.position.x(), ghost.position.y(), ghost.position.z()}},
          {"along_m", ghost.along},
          {"left_m", ghost.left},
          {"up_m", ghost.up},
          {"yaw_deg", ghost.yaw * kDegrees},
          {"size_m", ghost.size()},
          {"planes", ghost.planes},
          {"left_over_m", ghost.residual}};
}

Json to_json(const map::MapEntropy& entropy) {
  return {{"mean", entropy.mean},
          {"radius_m", entropy.radius},
          {"points", entropy.points},
          {"mean_neighbours", entropy.neighbours}};
}

}  // namespace lidar_mapping::tools
