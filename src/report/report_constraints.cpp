// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>
#include <optional>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "report_figures.hpp"
#include "report_statistics.hpp"

namespace lidar_mapping::report {

namespace {

using PoseOf = std::map<KeyFrameIndex, Pose>;

PoseOf by_index(const KeyFramePoses& poses) {
  PoseOf found;
  for (const KeyFramePose& pose : poses.poses) found[pose.index] = pose.T_map_base;
  return found;
}

using Verdicts = std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict>;

json::Json loop_row(const LoopVerdict& verdict) {
  return {{"from", verdict.from},
          {"to", verdict.to},
          {"source", to_string(verdict.source)},
          {"verdict", to_string(verdict.verdict)},
          {"reason", verdict.reason}};
}

/// The motion that these poses have in addition to that of the loop; empty without a pose for one
/// of its key frames.
std::optional<Pose> residual_of(const Loop& loop, const PoseOf& poses) {
  const auto from = poses.find(loop.from);
  const auto to = poses.find(loop.to);
  if (from == poses.end() || to == poses.end()) return std::nullopt;
  return loop.T_from_to.inverse() * (from->second.inverse() * to->second);
}

/// Removes the verdict on a loop from the others; a loop without one was accepted.
LoopVerdict take_verdict(const Loop& loop, Verdicts& verdicts) {
  const auto known = verdicts.find({loop.from, loop.to});
  if (known == verdicts.end()) return verdict_on(loop, Verdict::kAccepted, "");
  const LoopVerdict verdict = known->second;
  verdicts.erase(known);
  return verdict;
}

}  // namespace

bool is_in_enu(const session::Session& session) {
  const auto config = pipeline::stored_config<back_end::BackEndConfig>(session);
  return config.use_gnss && session.datum().has_value();
}

json::Json loop_figures(const ReportInput& input) {
  const PoseOf poses = by_index(input.poses);
  const PoseOf odometry = by_index(input.odometry);
  Verdicts verdicts = newest_verdicts(input.session.verdicts());
  json::Json rows = json::Json::array();
  std::vector<double> metres;
  std::vector<double> degrees;
  for (const Loop& loop : input.session.loops()) {
    const std::optional<Pose> residual = residual_of(loop, poses);
    if (!residual) continue;
    const LoopVerdict verdict = take_verdict(loop, verdicts);
    json::Json row = loop_row(verdict);
    row["residual_m"] = residual->translation.norm();
    row["odometry_residual_m"] = residual_of(loop, odometry).value().translation.norm();
    row["residual_deg"] = rotation_angle(residual->rotation) * kDegPerRad;
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

json::Json gnss_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  std::map<Stamp, std::size_t> at;
  for (std::size_t i = 0; i < input.poses.poses.size(); ++i) at[input.poses.poses[i].stamp] = i;
  std::vector<evaluation::PosePair> pairs;
  std::vector<Eigen::Matrix3d> covariances;
  for (const GnssPosition& gnss : back_end.positions()) {
    const auto found = at.find(gnss.stamp);
    if (found == at.end()) continue;
    const Pose& pose = input.poses.poses[found->second].T_map_base;
    evaluation::PosePair pair;
    pair.stamp = gnss.stamp;
    pair.truth.translation = gnss.p_enu_antenna;
    pair.estimate.translation = pose * gnss.p_base_antenna;
    pairs.push_back(pair);
    covariances.push_back(gnss.covariance);
  }
  const bool in_enu = is_in_enu(input.session);
  if (!in_enu && pairs.size() < 3) pairs.clear();  // too few to tell where the map lies
  if (!in_enu && !pairs.empty()) pairs = aligned(pairs, evaluation::rigid_alignment(pairs));
  const auto distances = distances_of(input.poses);
  json::Json rows = json::Json::array();
  std::vector<double> sigmas;
  std::vector<double> horizontal;
  std::vector<double> vertical;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool with_height = has_height(covariances[i]);
    Eigen::Vector3d d = pairs[i].truth.translation - pairs[i].estimate.translation;
    if (!with_height) d.z() = 0.0;
    sigmas.push_back(std::sqrt(0.5 * covariances[i].topLeftCorner<2, 2>().trace()));
    rows.push_back({distances[at.at(pairs[i].stamp)], d.x(), d.y(), d.z(), sigmas[i],
                    pairs[i].truth.translation.x(), pairs[i].truth.translation.y()});
    horizontal.push_back(d.head<2>().norm());
    if (with_height) vertical.push_back(std::abs(d.z()));
  }
  return {{"positions", pairs.size()},
          {"used_by_graph", in_enu},
          {"median_horizontal_m", quantile(horizontal, 0.5)},
          {"p95_horizontal_m", quantile(horizontal, 0.95)},
          {"median_vertical_m", quantile(vertical, 0.5)},
          {"p95_vertical_m", quantile(vertical, 0.95)},
          {"median_stated_sigma_m", quantile(sigmas, 0.5)},
          {"columns", {"distance", "east", "north", "up", "stated_sigma", "x", "y"}},
          {"rows", rows}};
}

}  // namespace lidar_mapping::report
