// SPDX-License-Identifier: BSD-3-Clause
#include "map_noise.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::localization {

namespace {

/// m between two matches that are compared. Chosen: over less, both see the same surfaces and are
/// off by the same; over more, the drift of odometry (0.02 %) counts.
constexpr double kComparedDistance = 10.0;
/// m between the matches that are kept. Chosen: the edge of a voxel.
constexpr double kSpacing = 1.0;
/// m on which two matches are not compared either: the map was left in between. Chosen: more than
/// the distance and the spacing.
constexpr double kLongestDistance = 12.0;
/// Comparisons over which the means are taken. Chosen: a map may be worse elsewhere.
constexpr double kGreatestWeight = 50.0;
/// Smallest standard deviations. Chosen: a map is not more exact than a tenth of the range noise;
/// m, and rad (0.006 degrees).
constexpr double kLeast = 0.002;
constexpr double kLeastAngle = 1e-4;

/// The difference of two motions has the error of both of their ends in three coordinates.
double variance_of(const Eigen::Vector3d& difference) { return difference.squaredNorm() / 6.0; }

}  // namespace

void MapNoise::move(const Pose& T_previous_base) {
  T_odom_base_ = T_odom_base_ * T_previous_base;
  distance_ += T_previous_base.translation.norm();
}

void MapNoise::add_match(const Pose& T_map_base) {
  const Match now{T_map_base, T_odom_base_, distance_};
  if (!matches_.empty() && now.distance < matches_.back().distance + kSpacing) return;
  matches_.push_back(now);
  while (now.distance > matches_.front().distance + kComparedDistance) {
    if (now.distance < matches_.front().distance + kLongestDistance) learn(matches_.front(), now);
    matches_.pop_front();
  }
}

void MapNoise::learn(const Match& before, const Match& now) {
  const Pose difference = (before.T_map_base.inverse() * now.T_map_base).inverse() *
                          (before.T_odom_base.inverse() * now.T_odom_base);
  weight_ = std::min(weight_ + 1.0, kGreatestWeight);
  variance_ += (variance_of(difference.translation) - variance_) / weight_;
  variance_angle_ += (variance_of(log_so3(difference.rotation)) - variance_angle_) / weight_;
}

double MapNoise::stddev() const { return std::max(kLeast, std::sqrt(variance_)); }

double MapNoise::stddev_angle() const { return std::max(kLeastAngle, std::sqrt(variance_angle_)); }

}  // namespace lidar_mapping::localization
