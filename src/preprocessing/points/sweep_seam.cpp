// SPDX-License-Identifier: BSD-3-Clause
#include "points/sweep_seam.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace lidar_mapping::preprocessing {

namespace {

// Points at the end of a sweep. Chosen: bounds the time.
constexpr std::size_t kMaxPoints = 400;
constexpr float kMinRange = 3.0F;   // m; chosen: nearer points belong to the vehicle
constexpr float kMaxRange = 50.0F;  // m; chosen: beyond, neighbouring points are too far apart
// m between the distances to both beginnings. Chosen so that a vote is clear: several times the
// range noise (0.02 m), and the path of a vehicle at 1.5 m/s during a sweep of 0.1 s.
constexpr float kMinDifference = 0.15F;
// m to the nearer beginning. Chosen: the spacing of neighbouring points at kMaxRange (0.4 degrees:
// 0.35 m).
constexpr float kMaxGap = 0.4F;
constexpr std::size_t kMinPoints = 4;  // with a clear vote; chosen: fewer may be a moving object
constexpr std::size_t kMinScans = 10;  // with a majority; chosen: more decide later
// In units of the span of a sweep: after a lost scan the seam is none. Chosen between 1 and 2.
constexpr double kMaxPause = 1.5;

float distance_to(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& point) {
  float nearest_squared = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& p : points)
    nearest_squared = std::min(nearest_squared, (p - point).squaredNorm());
  return std::sqrt(nearest_squared);
}

/// Number of points at the end of a sweep that fit the beginning of one sweep clearly better than
/// that of the other.
struct Votes {
  std::size_t own = 0;
  std::size_t next = 0;

  bool are_for_own() const { return own + next >= kMinPoints && own > 3 * next; }
  bool are_for_next() const { return own + next >= kMinPoints && next > 3 * own; }
};

using Points = std::vector<Eigen::Vector3f>;

Votes votes_of(const Points& end, const Points& own_begin, const Points& next_begin) {
  Votes votes;
  const std::size_t step = 1 + end.size() / kMaxPoints;
  for (std::size_t i = 0; i < end.size(); i += step) {
    const Eigen::Vector3f& point = end[i];
    const float range = point.norm();
    if (range < kMinRange || range > kMaxRange) continue;
    const float to_own = distance_to(own_begin, point);
    const float to_next = distance_to(next_begin, point);
    if (std::min(to_own, to_next) > kMaxGap || std::abs(to_own - to_next) < kMinDifference)
      continue;
    ++(to_own < to_next ? votes.own : votes.next);
  }
  return votes;
}

}  // namespace

void SweepSeam::add(const CloudSummary& cloud) {
  const double span = cloud.last_time - cloud.first_time;
  const double since = to_seconds(cloud.stamp - previous_.stamp);
  if (!previous_.end_points.empty() && since > 0.0 && since < kMaxPause * span) {
    const Votes votes = votes_of(previous_.end_points, previous_.begin_points, cloud.begin_points);
    if (votes.are_for_own()) ++compensated_;
    if (votes.are_for_next()) ++raw_;
    // Of times that run backwards the beginning of a sweep joins the end of the next one.
    const bool joins_end =
        votes_of(previous_.begin_points, previous_.end_points, cloud.end_points).are_for_next();
    if (joins_end) ++reversed_;
  }
  previous_ = cloud;
}

bool SweepSeam::is_compensated() const {
  return compensated_ >= kMinScans && compensated_ > 4 * raw_ && !is_reversed();
}

bool SweepSeam::is_reversed() const { return reversed_ >= kMinScans && reversed_ > 4 * raw_; }

}  // namespace lidar_mapping::preprocessing
