// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/pair_match.hpp"

#include <cmath>
#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "scan_alignment.hpp"
#include "submap_builder.hpp"
#include "verified_candidate.hpp"

namespace lidar_mapping::loop_closing {

namespace {

/// The trajectory up to `to`, so that `to` is the newest node.
Trajectory drive_until(const std::vector<KeyFrame>& key_frames, KeyFrameIndex to) {
  Trajectory trajectory;
  for (const KeyFrame& key_frame : key_frames) {
    if (key_frame.index <= to) trajectory.append(key_frame);
  }
  return trajectory;
}

Trajectory::NodeId node_of(const Trajectory& trajectory, KeyFrameIndex index) {
  const auto node = trajectory.find(index);
  if (node) return *node;
  throw InputError("there is no key frame " + std::to_string(index));
}

/// The poses where the two bird's-eye views agree best, one for each of the two headings that the
/// descriptors allow.
std::vector<Pose> starting_poses_by_views(CloudSource& clouds, KeyFrameIndex from,
                                          KeyFrameIndex to) {
  const PointCloudPtr older = clouds.cloud(from);
  const PointCloudPtr newer = clouds.cloud(to);
  if (!older || !newer) return {};
  const Appearance a = appearance_of(positions(*older));
  const Appearance b = appearance_of(positions(*newer));
  const double yaw = a.descriptor.compare(b.descriptor).yaw;
  const ViewCorrelator correlator(a.view);
  std::vector<Pose> poses;
  for (const double candidate_yaw : {yaw, yaw + kPi}) {
    Pose start;
    start.translation.head<2>() = correlator.match(b.view.cells(), candidate_yaw).translation;
    start.rotation = Eigen::AngleAxisd(candidate_yaw, Eigen::Vector3d::UnitZ());
    poses.push_back(start);
  }
  return poses;
}

std::vector<Pose> starting_poses(CloudSource& clouds, KeyFrameIndex from, KeyFrameIndex to,
                                 const std::optional<Pose>& guess) {
  if (guess) return {*guess};
  std::vector<Pose> poses = starting_poses_by_views(clouds, from, to);
  poses.push_back(Pose::Identity());
  return poses;
}

/// Switches off the check of the distance, so that only the clouds count.
LoopClosingConfig without_distance_limit(LoopClosingConfig config) {
  config.max_loop_distance = std::numeric_limits<double>::infinity();
  return config;
}

VerifiedCandidate verify(const QueryScan& query, const Submap& submap, Trajectory::NodeId from,
                         const Pose& start, const LoopClosingConfig& config,
                         ScanAlignment& alignment) {
  VerifiedCandidate result;
  result.candidate.node = from;
  result.candidate.source = LoopSource::kManual;
  result.candidate.T_from_to = start;
  result.candidate.prior.T_from_to = start;
  result.match.alignment = alignment.align(query.points, submap.surface, start);
  result.match.figures = measure_match(query, submap, result.match.alignment.T_target_source,
                                       config.fitness_score_max_range);
  result.decision = decide(result.match, result.candidate.prior, config);
  return result;
}

bool is_better(const VerifiedCandidate& a, const VerifiedCandidate& b) {
  const bool accepted_a = a.decision.verdict == Verdict::kAccepted;
  const bool accepted_b = b.decision.verdict == Verdict::kAccepted;
  return accepted_a != accepted_b ? accepted_a : a.margin() > b.margin();
}

}  // namespace

PairMatch match_pair(const LoopClosingConfig& config, CloudSource& clouds,
                     const Eigen::Vector3d& p_base_lidar, const std::vector<KeyFrame>& key_frames,
                     KeyFrameIndex from, KeyFrameIndex to, const std::optional<Pose>& guess) {
  const Trajectory trajectory = drive_until(key_frames, to);
  const Trajectory::NodeId older = node_of(trajectory, from);
  const Trajectory::NodeId newer = node_of(trajectory, to);
  const auto min_gap = static_cast<Trajectory::NodeId>(config.extend_frame_num + kQueryKeyFrames);
  if (older + min_gap > newer) {
    throw InputError("key frames " + std::to_string(from) + " and " + std::to_string(to) +
                     " are too near in the drive to be matched; the second must come at least " +
                     std::to_string(min_gap) + " key frames later");
  }
  SubmapBuilder submaps(config, clouds);
  submaps.set_sensor_origin(p_base_lidar);
  const bool have_scan = submaps.add_newest(key_frames[newer]) != nullptr;
  const auto query = have_scan ? submaps.query(trajectory) : std::nullopt;
  const auto submap = submaps.around(trajectory, older);
  PairMatch result;
  if (!query || !submap) {
    result.verdict = {from,
                      to,
                      trajectory[newer].stamp,
                      LoopSource::kManual,
                      Verdict::kUndecided,
                      "the cloud of one of the two is not available"};
    return result;
  }
  const LoopClosingConfig limits = without_distance_limit(config);
  ScanAlignment alignment(config);
  std::optional<VerifiedCandidate> best;
  for (const Pose& start : starting_poses(clouds, from, to, guess)) {
    const VerifiedCandidate verified = verify(*query, *submap, older, start, limits, alignment);
    if (!best || is_better(verified, *best)) best = verified;
  }
  result.verdict = to_verdict(*best, trajectory);
  if (best->decision.verdict == Verdict::kAccepted) {
    result.loop = to_loop(*best, trajectory, config);
  }
  return result;
}

}  // namespace lidar_mapping::loop_closing
