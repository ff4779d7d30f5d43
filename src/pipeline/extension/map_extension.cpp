// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/map_extension.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::pipeline {

namespace {

using localization::LocalizationState;

/// Coverage from which on the map knows the surroundings. Chosen: above the 0.4 below which the
/// localiser follows no place; where a street goes on behind the end of the map, its coverage
/// falls slowly.
constexpr double kKnownCoverage = 0.6;
/// Agreement from which on the map shows the surroundings, also while the place is not confirmed.
/// Chosen: as the localiser has it for a place that no verification confirms.
constexpr double kShownAgreement = 0.5;
/// m to the nearest key frame of the map, from which on the place itself is new. Chosen: above the
/// distance of lanes and of key frames, below the range at which a scan knows its surroundings.
constexpr double kNewDistance = 15.0;
/// m of known path beside each new one. Chosen: behind 20 m the back end trusts the odometry of a
/// new segment fully.
constexpr double kOverlap = 30.0;
/// m between ties. Chosen: nearer ones have their errors in common.
constexpr double kTieSpacing = 5.0;

/// Chooses the new sections of a drive.
class Planner {
 public:
  Planner(const std::vector<LocalizedKeyFrame>& drive, const KeyFramePoses& map)
      : drive_(drive), map_(map), step_lengths_(drive.size(), 0.0), is_new_(drive.size(), false) {
    for (std::size_t i = 1; i < drive.size(); ++i) {
      if (is_connected(i)) step_lengths_[i] = motion_to(i).translation.norm();
    }
  }

  MapExtension plan() {
    for (std::size_t begin = 0; begin < drive_.size();) {
      const std::size_t end = end_of_segment(begin);
      if (is_found(begin, end)) {
        find_new(begin, end);
        for (const NewSection& run : long_runs(begin, end)) add_section(run, begin, end);
      } else {
        extension_.omitted.never_found += path_length_of(begin, end);
      }
      begin = end;
    }
    keep_tied();
    return std::move(extension_);
  }

 private:
  /// Whether odometry leads to a key frame from the one before.
  bool is_connected(std::size_t i) const {
    return i > 0 && drive_[i].key_frame.segment == drive_[i - 1].key_frame.segment;
  }
  Pose motion_to(std::size_t i) const {
    return drive_[i - 1].key_frame.T_odom_base.inverse() * drive_[i].key_frame.T_odom_base;
  }
  std::size_t end_of_segment(std::size_t begin) const {
    std::size_t end = begin + 1;
    while (end < drive_.size() && is_connected(end)) ++end;
    return end;
  }
  double path_length_of(std::size_t begin, std::size_t end) const {
    double path_length = 0.0;
    for (std::size_t i = begin; i < end; ++i) path_length += step_lengths_[i];
    return path_length;
  }
  bool is_followed(std::size_t i) const {
    return drive_[i].place.state == LocalizationState::kFollowing;
  }
  bool is_found(std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) {
      if (is_followed(i)) return true;
    }
    return false;
  }
  /// The map knows the surroundings and the place is certain, so a tie can begin here.
  bool is_anchor(std::size_t i) const { return is_followed(i) && !is_new_[i]; }

  // Of a segment in which a key frame is followed.
  void find_new(std::size_t begin, std::size_t end);
  std::vector<Pose> carried_poses(std::size_t begin, std::size_t end) const;
  bool observes_new(std::size_t i, const Pose& T_map_base) const;
  const KeyFramePose& nearest(const Pose& T_map_base) const;
  std::vector<NewSection> long_runs(std::size_t begin, std::size_t end);
  void leave_out_short(const NewSection& run);
  void add_section(NewSection run, std::size_t begin, std::size_t end);
  std::size_t overlap_before(std::size_t first, std::size_t begin) const;
  std::size_t overlap_behind(std::size_t last, std::size_t end) const;
  void keep_tied();
  std::vector<Loop> ties_of(const NewSection& section) const;
  Loop tie_to(std::size_t i) const;

  const std::vector<LocalizedKeyFrame>& drive_;
  const KeyFramePoses& map_;
  std::vector<double> step_lengths_;  ///< Path length to each key frame in its segment, m.
  std::vector<bool> is_new_;
  MapExtension extension_;
};

void Planner::find_new(std::size_t begin, std::size_t end) {
  const std::vector<Pose> poses = carried_poses(begin, end);
  for (std::size_t i = begin; i < end; ++i) is_new_[i] = observes_new(i, poses[i - begin]);
}

/// T_map_base of the key frames of a segment: by the localisation where it is followed, else by
/// odometry from the last key frame before that was, or from the first one behind.
std::vector<Pose> Planner::carried_poses(std::size_t begin, std::size_t end) const {
  const auto T_map_odom_at = [&](std::size_t i) {
    return drive_[i].place.T_map_base * drive_[i].key_frame.T_odom_base.inverse();
  };
  std::size_t first = begin;
  while (!is_followed(first)) ++first;
  Pose T_map_odom = T_map_odom_at(first);
  std::vector<Pose> poses;
  for (std::size_t i = begin; i < end; ++i) {
    if (is_followed(i)) T_map_odom = T_map_odom_at(i);
    poses.push_back(T_map_odom * drive_[i].key_frame.T_odom_base);
  }
  return poses;
}

/// While the place is searched for nothing is known of the surroundings, so that its distance from
/// the map decides.
bool Planner::observes_new(std::size_t i, const Pose& T_map_base) const {
  const localization::LocalizationResult& place = drive_[i].place;
  if (place.state == LocalizationState::kBesideMap) return place.agreement < kShownAgreement;
  if (is_followed(i) && place.coverage >= kKnownCoverage) return false;
  const Eigen::Vector3d& p_map = nearest(T_map_base).T_map_base.translation;
  return (p_map - T_map_base.translation).norm() > kNewDistance;
}

/// The key frame of the map that is nearest to a pose in it.
const KeyFramePose& Planner::nearest(const Pose& T_map_base) const {
  const auto distance = [&](const KeyFramePose& pose) {
    return (pose.T_map_base.translation - T_map_base.translation).squaredNorm();
  };
  return *std::min_element(
      map_.poses.begin(), map_.poses.end(),
      [&](const KeyFramePose& a, const KeyFramePose& b) { return distance(a) < distance(b); });
}

/// Runs of new key frames in a segment. Shorter paths between two of them do not part them.
std::vector<NewSection> Planner::long_runs(std::size_t begin, std::size_t end) {
  std::vector<NewSection> runs;
  for (std::size_t i = begin; i < end; ++i) {
    if (!is_new_[i]) continue;
    const bool goes_on = !runs.empty() && path_length_of(runs.back().end, i) < kLeastNewPathLength;
    if (!goes_on) runs.push_back({i, i, 0.0, {}});
    runs.back().end = i + 1;
    runs.back().new_path_length += step_lengths_[i];
  }
  std::vector<NewSection> kept;
  for (const NewSection& run : runs) {
    if (run.new_path_length < kLeastNewPathLength) {
      leave_out_short(run);
    } else {
      kept.push_back(run);
    }
  }
  return kept;
}

void Planner::leave_out_short(const NewSection& run) {
  extension_.omitted.too_short += run.new_path_length;
  for (std::size_t i = run.begin; i < run.end; ++i) is_new_[i] = false;
}

/// Adds the known paths on both sides. Sections of a segment that meet become one.
void Planner::add_section(NewSection run, std::size_t begin, std::size_t end) {
  run.begin = overlap_before(run.begin, begin);
  run.end = overlap_behind(run.end - 1, end) + 1;
  auto& sections = extension_.sections;
  const bool meets = !sections.empty() && (run.begin < sections.back().end ||
                                           (run.begin == sections.back().end && run.begin > begin));
  if (!meets) return sections.push_back(run);
  sections.back().end = std::max(sections.back().end, run.end);
  sections.back().new_path_length += run.new_path_length;
}

/// The first key frame of the known path before a new key frame. It ends where the place was
/// followed: what lies behind that is of no use.
std::size_t Planner::overlap_before(std::size_t first, std::size_t begin) const {
  std::size_t last_anchor = first;
  double path_length = 0.0;
  for (std::size_t i = first; i > begin && path_length < kOverlap;) {
    const double step = step_lengths_[i--];
    if (!is_anchor(i)) continue;
    path_length += step;
    last_anchor = i;
  }
  return last_anchor;
}

/// The last key frame of the known path behind a new key frame.
std::size_t Planner::overlap_behind(std::size_t last, std::size_t end) const {
  std::size_t last_anchor = last;
  double path_length = 0.0;
  for (std::size_t i = last + 1; i < end && path_length < kOverlap; ++i) {
    if (!is_anchor(i)) continue;
    path_length += step_lengths_[i];
    last_anchor = i;
  }
  return last_anchor;
}

void Planner::keep_tied() {
  std::vector<NewSection> kept;
  for (NewSection& section : extension_.sections) {
    section.ties = ties_of(section);
    if (section.ties.size() >= kLeastTies) {
      kept.push_back(std::move(section));
    } else {
      extension_.omitted.not_tied += section.new_path_length;
    }
  }
  extension_.sections = std::move(kept);
}

std::vector<Loop> Planner::ties_of(const NewSection& section) const {
  std::vector<Loop> ties;
  double path_length_since_tie = kTieSpacing;
  for (std::size_t i = section.begin; i < section.end; ++i) {
    if (i > section.begin) path_length_since_tie += step_lengths_[i];
    if (!is_anchor(i) || path_length_since_tie < kTieSpacing) continue;
    ties.push_back(tie_to(i));
    path_length_since_tie = 0.0;
  }
  return ties;
}

/// The localisation holds odometry already, so its covariance is that of the tie.
Loop Planner::tie_to(std::size_t i) const {
  const auto& [key_frame, place] = drive_[i];
  const KeyFramePose& from = nearest(place.T_map_base);
  Loop tie;
  tie.from = from.index;
  tie.to = key_frame.index;
  tie.stamp = key_frame.stamp;
  tie.T_from_to = from.T_map_base.inverse() * place.T_map_base;
  tie.covariance = place.covariance;
  tie.overlap = place.coverage;
  return tie;
}

}  // namespace

MapExtension plan_extension(const std::vector<LocalizedKeyFrame>& drive, const KeyFramePoses& map) {
  return Planner(drive, map).plan();
}

}  // namespace lidar_mapping::pipeline
