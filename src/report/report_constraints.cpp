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
#include "lidar_mapping/session/map_datum.hpp"

#include "report_figures.hpp"

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

/// A position of GNSS beside that of its antenna on the map.
struct MeasuredPosition {
  std::size_t pose = 0;        ///< number of the key frame's pose
  evaluation::PosePair pair;   ///< translations alone; the truth is GNSS
  Eigen::Matrix3d covariance;  ///< m^2, East-North-Up
};

/// The positions at key frames that have a pose.
std::vector<MeasuredPosition> measured_positions(const KeyFramePoses& poses,
                                                 const std::vector<GnssPosition>& positions) {
  std::map<Stamp, std::size_t> at;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) at[poses.poses[i].stamp] = i;
  std::vector<MeasuredPosition> measured;
  for (const GnssPosition& gnss : positions) {
    const auto found = at.find(gnss.stamp);
    if (found == at.end()) continue;
    const Pose& pose = poses.poses[found->second].T_map_base;
    evaluation::PosePair pair;
    pair.stamp = gnss.stamp;
    pair.truth.translation = gnss.p_enu_antenna;
    pair.estimate.translation = pose * gnss.p_base_antenna;
    measured.push_back({found->second, pair, gnss.covariance});
  }
  return measured;
}

/// Lays the map onto the positions, which tell where it lies; too few of them are left out.
void align(std::vector<MeasuredPosition>& measured) {
  constexpr std::size_t kLeastPositions = 3;  // by definition: of a rigid alignment
  if (measured.size() < kLeastPositions) return measured.clear();
  std::vector<evaluation::PosePair> pairs;
  for (const MeasuredPosition& position : measured) pairs.push_back(position.pair);
  pairs = aligned(pairs, evaluation::rigid_alignment(pairs));
  for (std::size_t i = 0; i < pairs.size(); ++i) measured[i].pair = pairs[i];
}

/// Differences of the map from GNSS, in m.
struct GnssDifferences {
  json::Json rows = json::Json::array();
  std::vector<double> sigmas;  ///< stated horizontal standard deviations
  std::vector<double> horizontal;
  std::vector<double> vertical;  ///< where GNSS gives the height
};

/// `distances` are those along the drive at the poses, m.
GnssDifferences differences_of(const std::vector<MeasuredPosition>& measured,
                               const std::vector<double>& distances) {
  GnssDifferences found;
  for (const MeasuredPosition& position : measured) {
    const bool with_height = has_height(position.covariance);
    const Eigen::Vector3d& truth = position.pair.truth.translation;
    Eigen::Vector3d d = truth - position.pair.estimate.translation;
    if (!with_height) d.z() = 0.0;
    const double sigma = horizontal_stddev(position.covariance);
    found.rows.push_back(
        {distances[position.pose], d.x(), d.y(), d.z(), sigma, truth.x(), truth.y()});
    found.sigmas.push_back(sigma);
    found.horizontal.push_back(d.head<2>().norm());
    if (with_height) found.vertical.push_back(std::abs(d.z()));
  }
  return found;
}

}  // namespace

bool is_in_enu(const session::Session& session) {
  if (session.poses_in_enu()) return session::map_datum(session).has_value();
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
  const bool in_enu = is_in_enu(input.session);
  std::vector<MeasuredPosition> measured = measured_positions(input.poses, back_end.positions());
  if (!in_enu) align(measured);
  const GnssDifferences found = differences_of(measured, input.distances);
  return {{"positions", measured.size()},
          {"used_by_graph", in_enu},
          {"median_horizontal_m", quantile(found.horizontal, 0.5)},
          {"p95_horizontal_m", quantile(found.horizontal, 0.95)},
          {"median_vertical_m", quantile(found.vertical, 0.5)},
          {"p95_vertical_m", quantile(found.vertical, 0.95)},
          {"median_stated_sigma_m", quantile(found.sigmas, 0.5)},
          {"columns", {"distance", "east", "north", "up", "stated_sigma", "x", "y"}},
          {"rows", found.rows}};
}

}  // namespace lidar_mapping::report
