// SPDX-License-Identifier: BSD-3-Clause
#include "imu/tilt_scatter.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::back_end {

namespace {

/// Lower bound. Chosen: a few minutes of good agreement do not prove that a sensor is perfect.
constexpr double kMinFraction = 0.25;
/// Least number of pairs of means for a variance (chosen: its root is good to a quarter), and least
/// length in key frames of the longest means (chosen so that errors that neighbours have in common
/// are seen).
constexpr std::size_t kMinPairs = 8;
constexpr std::size_t kMinLongestMean = 16;
/// Length of the mean of the heading vectors above which the vehicle is taken to drive in one
/// direction only. A mounting error of the IMU is visible only if the vehicle turns. Chosen: that
/// of a drive which spends equal times in two directions at right angles (sqrt(2) / 2).
constexpr double kMaxMeanHeadingLength = 0.7;

using Directions = std::vector<Eigen::Vector3d>;

/// The vertical by the IMU in the axes of odometry, by segment. Without errors it is constant.
std::vector<Directions> verticals_in_odometry(const DriveGraph& drive) {
  std::vector<Directions> result(drive.in_enu.size());
  for (const DriveImu& imu : drive.imu) {
    if (!imu.sample.orientation) continue;
    const DriveNode& node = drive.nodes[imu.node];
    const Eigen::Quaterniond R_odom_world =
        node.T_odom_base.rotation * imu.sample.orientation->conjugate();
    result[node.segment].push_back(R_odom_world * Eigen::Vector3d::UnitZ());
  }
  return result;
}

/// Allan variance: half the mean square of the difference between successive means of `length`
/// values, per component.
struct AllanVariance {
  double sum = 0.0;
  std::size_t pairs = 0;

  void add(const Directions& directions, std::size_t length) {
    Eigen::Vector3d previous;
    for (std::size_t begin = 0; begin + length <= directions.size(); begin += length) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::size_t i = begin; i < begin + length; ++i) mean += directions[i];
      mean /= static_cast<double>(length);
      if (begin > 0) {
        sum += 0.5 * (mean - previous).squaredNorm();
        ++pairs;
      }
      previous = mean;
    }
  }
  /// A direction has two components.
  double value() const { return sum / (2.0 * static_cast<double>(pairs)); }
};

/// True if other constraints than odometry determine the height. Otherwise the noise of a tilt with
/// a large weight would accumulate along the path, while odometry alone recovers its height when it
/// returns to a location.
bool is_height_constrained(const DriveGraph& drive, const BackEndConfig& config) {
  if (config.use_gnss && !config.georeference_only && !drive.gnss.empty()) return true;
  return config.use_loop_close &&
         std::any_of(drive.loops.begin(), drive.loops.end(),
                     [](const DriveLoop& loop) { return loop.used || !loop.evaluated; });
}

bool vehicle_turns(const DriveGraph& drive) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const DriveNode& node : drive.nodes) {
    sum += node.T_odom_base.rotation * Eigen::Vector3d::UnitX();
  }
  return sum.norm() < kMaxMeanHeadingLength * static_cast<double>(drive.nodes.size());
}

}  // namespace

double tilt_stddev(const DriveGraph& drive, const BackEndConfig& config) {
  const double configured = config.imu_orientation_stddev;
  if (!is_height_constrained(drive, config) || !vehicle_turns(drive)) return configured;
  const std::vector<Directions> segments = verticals_in_odometry(drive);
  // Of one value, if as many independent values had the variance of the means.
  double variance = 0.0;
  std::size_t length = 1;
  for (;; length *= 2) {
    AllanVariance of_means;
    for (const Directions& directions : segments) of_means.add(directions, length);
    if (of_means.pairs < kMinPairs) break;
    variance = std::max(variance, static_cast<double>(length) * of_means.value());
  }
  if (length <= kMinLongestMean) return configured;
  return std::clamp(std::sqrt(variance), kMinFraction * configured, configured);
}

}  // namespace lidar_mapping::back_end
