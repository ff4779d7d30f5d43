// SPDX-License-Identifier: BSD-3-Clause
#include "points/sweep_seam.hpp"

#include <algorithm>
#include <limits>

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
};

Votes votes_of(const CloudSummary& sweep, const CloudSummary& next) {
  Votes votes;
  const std::size_t step = 1 + sweep.end_points.size() / kMaxPoints;
  for (std::size_t i = 0; i < sweep.end_points.size(); i += step) {
    const Eigen::Vector3f& point = sweep.end_points[i];
    const float range = point.norm();
    if (range < kMinRange || range > kMaxRange) continue;
    const float to_own = distance_to(sweep.begin_points, point);
    const float to_next = distance_to(next.begin_points, point);
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
    const Votes votes = votes_of(previous_, cloud);
    if (votes.own + votes.next >= kMinPoints) {
      if (votes.own > 3 * votes.next) ++compensated_;
      if (votes.next > 3 * votes.own) ++raw_;
    }
  }
  previous_ = cloud;
}

bool SweepSeam::is_compensated() const {
  return compensated_ >= kMinScans && compensated_ > 4 * raw_;
}

}  // namespace lidar_mapping::preprocessing
