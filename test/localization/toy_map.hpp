// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "lidar_mapping/localization/localizer.hpp"

#include "toy_world.hpp"

namespace lidar_mapping::localization::test {

using loop_closing::test::along;
using loop_closing::test::DriveClouds;
using loop_closing::test::make_town;
using loop_closing::test::planar;
using loop_closing::test::seen_downwards;
using loop_closing::test::ToyWorld;

/// What a perfect mapping makes of key frames at these poses.
inline MapSource source_of(const std::vector<Pose>& poses,
                           const Eigen::Vector3d& p_base_lidar = ToyWorld::sensor()) {
  MapSource source;
  source.p_base_lidar = p_base_lidar;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.stamp = from_seconds(static_cast<double>(i));
    key_frame.T_odom_base = poses[i];
    source.key_frames.push_back(key_frame);
    source.poses.poses.push_back({key_frame.index, key_frame.stamp, poses[i]});
  }
  return source;
}

/// The map of a world, made along a path.
class ToyMap {
 public:
  ToyMap(const ToyWorld& world, const std::vector<Pose>& path)
      : clouds_(world, path), index_(source_of(path), clouds_, {}) {}
  MapIndex& index() { return index_; }

 private:
  DriveClouds clouds_;
  MapIndex index_;
};

constexpr double kStreets = 48.0;  ///< m between the streets of a town

inline const ToyWorld& town() {
  static const ToyWorld world = make_town(150.0, kStreets, 3);
  return world;
}

/// The map of one street of town() and of one across.
inline MapIndex& town_map() {
  static ToyMap map(town(), along({{-90.0, 0.0}, {kStreets, 0.0}, {kStreets, 90.0}}));
  return map.index();
}

/// A vehicle in a world that localises itself, scan by scan.
class Vehicle {
 public:
  Vehicle(const ToyWorld& world, MapIndex& map) : world_(world), localizer_(map) {}

  Localizer& localizer() { return localizer_; }
  /// Goes on to a pose; odometry tells so, unless it is said to be another motion.
  LocalizationResult go_to(const Pose& truth, const std::optional<Pose>& felt = std::nullopt) {
    LocalizerInput input;
    input.scan = {from_seconds(0.1 * ++scans_), seen_at(truth)};
    input.T_previous_base = felt.value_or(last_.inverse() * truth);
    input.covariance = diagonal_covariance(sigma_, 0.0005);
    input.is_connected = is_connected_;
    input.p_base_lidar = ToyWorld::sensor();
    is_connected_ = true;
    last_ = truth;
    return localizer_.process(input);
  }
  /// Goes along a path; odometry may take the motion to its first pose for another one.
  std::vector<LocalizationResult> drive(const std::vector<Pose>& path,
                                        std::optional<Pose> felt = std::nullopt) {
    std::vector<LocalizationResult> results;
    for (const Pose& pose : path) {
      results.push_back(go_to(pose, std::exchange(felt, std::nullopt)));
    }
    return results;
  }
  /// Odometry does not lead to the next scan.
  void interrupt() { is_connected_ = false; }
  /// Odometry claims a motion with this standard deviation, m.
  void distrust_odometry(double sigma) { sigma_ = sigma; }
  /// The sensor is covered: scans have at most so many points.
  void see_only(std::size_t points) { most_points_ = points; }

 private:
  PointCloud seen_at(const Pose& truth) const {
    PointCloud cloud = world_.scan(truth, 1000U + seed());
    const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points_);
    PointCloud seen;
    for (std::size_t i = 0; i < cloud.size(); i += step) seen.points.push_back(cloud.points[i]);
    return seen;
  }
  std::uint32_t seed() const { return static_cast<std::uint32_t>(scans_); }

  const ToyWorld& world_;
  Localizer localizer_;
  Pose last_;
  int scans_ = 0;
  bool is_connected_ = true;
  double sigma_ = 0.01;  // m
  std::size_t most_points_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace lidar_mapping::localization::test
