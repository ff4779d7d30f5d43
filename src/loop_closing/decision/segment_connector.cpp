// SPDX-License-Identifier: BSD-3-Clause
#include "decision/segment_connector.hpp"

#include <limits>

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kMaxKnownMatches = 100;  // chosen, bounds the comparisons per match
constexpr double kMaxSpeed =
    40.0;  // m/s (144 km/h), of the vehicle while nothing was recorded; chosen
// m, between two matches that confirm each other; chosen: the sum of the errors of both.
constexpr double kTranslationTolerance = 0.5;
// Added fraction of the path length between the matches; chosen: above the usual drift of odometry.
constexpr double kDriftTolerance = 0.02;
constexpr double kRotationTolerance = 0.1;  // rad (6 degrees); chosen in the same way

struct Ends {
  Trajectory::NodeId from;
  Trajectory::NodeId to;
};

Ends ends_of(const Loop& loop, const Trajectory& trajectory) {
  return {*trajectory.find(loop.from), *trajectory.find(loop.to)};
}

Pose odometry_between(const Trajectory& trajectory, Trajectory::NodeId a, Trajectory::NodeId b) {
  return trajectory[a].T_odom_base.inverse() * trajectory[b].T_odom_base;
}

/// True if odometry between two matches agrees with both.
bool are_consistent(const Loop& a, const Loop& b, const Trajectory& trajectory) {
  const Ends ends_a = ends_of(a, trajectory);
  const Ends ends_b = ends_of(b, trajectory);
  if (trajectory[ends_a.from].segment != trajectory[ends_b.from].segment) return false;
  if (trajectory[ends_a.to].segment != trajectory[ends_b.to].segment) return false;
  const Pose predicted = odometry_between(trajectory, ends_b.from, ends_a.from) * a.T_from_to *
                         odometry_between(trajectory, ends_a.to, ends_b.to);
  const Vector6d error = difference(predicted, b.T_from_to);
  const double path_length = trajectory.path_length_between(ends_a.from, ends_b.from) +
                             trajectory.path_length_between(ends_a.to, ends_b.to);
  return error.head<3>().norm() < kTranslationTolerance + kDriftTolerance * path_length &&
         error.tail<3>().norm() < kRotationTolerance;
}

/// Largest possible distance of the two key frames: the path lengths to the ends of their segments
/// and the distance that the vehicle may have travelled between these. Infinite for segments that
/// overlap in time, which come from two vehicles.
double max_distance_apart(const Ends& ends, const Trajectory& trajectory) {
  Trajectory::NodeId last = ends.from;
  while (trajectory[last + 1].segment == trajectory[ends.from].segment) ++last;
  Trajectory::NodeId first = ends.to;
  while (trajectory[first - 1].segment == trajectory[ends.to].segment) --first;
  const double gap = to_seconds(trajectory[first].stamp - trajectory[last].stamp);
  if (gap < 0.0) return std::numeric_limits<double>::infinity();
  return trajectory.path_length_between(ends.from, last) + kMaxSpeed * gap +
         trajectory.path_length_between(first, ends.to);
}

}  // namespace

std::vector<Loop> SegmentConnector::add(const Loop& loop, const Trajectory& trajectory) {
  const Ends ends = ends_of(loop, trajectory);
  bool accepted = max_distance_apart(ends, trajectory) <= min_path_length_;
  std::vector<KnownMatch*> consistent;
  for (KnownMatch& match : matches_) {
    if (!are_consistent(match.loop, loop, trajectory)) continue;
    consistent.push_back(&match);
    const double path_length =
        trajectory.path_length_between(ends_of(match.loop, trajectory).to, ends.to);
    accepted = accepted || match.accepted || path_length >= min_path_length_;
  }
  std::vector<Loop> result;
  if (accepted) result.push_back(loop);
  for (KnownMatch* match : consistent) {
    if (!accepted || match->accepted) continue;
    result.push_back(match->loop);
    match->accepted = true;
  }
  matches_.push_back({loop, accepted});
  if (matches_.size() > kMaxKnownMatches) matches_.erase(matches_.begin());
  return result;
}

}  // namespace lidar_mapping::loop_closing
