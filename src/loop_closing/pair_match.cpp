// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/pair_match.hpp"

#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "decision/verified_candidate.hpp"
#include "matching/scan_alignment.hpp"
#include "matching/submap_builder.hpp"

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
  const ViewCorrelator correlator(a.view);
  std::vector<Pose> poses;
  for (const double yaw : headings_by_views(a, b)) {
    poses.push_back(planar_pose(correlator.match(b.view.cells(), yaw).translation, yaw));
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

Candidate named_candidate(Trajectory::NodeId from, const Pose& start) {
  Candidate candidate;
  candidate.node = from;
  candidate.source = LoopSource::kManual;
  candidate.T_from_to = start;
  candidate.prior.T_from_to = start;
  return candidate;
}

/// Throws InputError if `older` is not old enough: scan and submap would share clouds.
void check_distance(const Trajectory& trajectory, Trajectory::NodeId older,
                    Trajectory::NodeId newer, int extend_frame_num) {
  const auto min_gap = static_cast<Trajectory::NodeId>(extend_frame_num + kQueryKeyFrames);
  if (older + min_gap <= newer) return;
  throw InputError("key frames " + std::to_string(trajectory[older].index) + " and " +
                   std::to_string(trajectory[newer].index) +
                   " are too near in the drive to be matched; the second must come at least " +
                   std::to_string(min_gap) + " key frames later");
}

/// The best of the matches from several starting poses.
VerifiedCandidate best_match(const LoopClosingConfig& config, const QueryScan& query,
                             const Submap& submap, Trajectory::NodeId older,
                             const std::vector<Pose>& starts) {
  const LoopClosingConfig limits = without_distance_limit(config);
  ScanAlignment alignment(config);
  std::optional<VerifiedCandidate> best;
  for (const Pose& start : starts) {
    const VerifiedCandidate next =
        verified(named_candidate(older, start), query, submap, limits, alignment);
    if (!best || is_better(next, *best)) best = next;
  }
  return best.value();
}

}  // namespace

PairMatch match_pair(const LoopClosingConfig& config, CloudSource& clouds,
                     const Eigen::Vector3d& p_base_lidar, const std::vector<KeyFrame>& key_frames,
                     KeyFrameIndex from, KeyFrameIndex to, const std::optional<Pose>& guess) {
  const Trajectory trajectory = drive_until(key_frames, to);
  const Trajectory::NodeId older = node_of(trajectory, from);
  const Trajectory::NodeId newer = node_of(trajectory, to);
  check_distance(trajectory, older, newer, config.extend_frame_num);
  SubmapBuilder submaps(config, clouds);
  submaps.set_sensor_origin(p_base_lidar);
  const bool have_scan = submaps.add_newest(key_frames[newer]) != nullptr;
  const auto query = have_scan ? submaps.query(trajectory) : std::nullopt;
  const auto submap = submaps.around(trajectory, older);
  const VerifiedCandidate best =
      query && submap
          ? best_match(config, *query, *submap, older, starting_poses(clouds, from, to, guess))
          : without_cloud(named_candidate(older, Pose::Identity()));
  PairMatch result{to_verdict(best, trajectory), std::nullopt};
  if (best.is_accepted()) result.loop = to_loop(best, trajectory, config);
  return result;
}

}  // namespace lidar_mapping::loop_closing
