// SPDX-License-Identifier: BSD-3-Clause
#include "tilt_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::back_end {

namespace {

/// However well a few minutes agree, no sensor is believed more than this share allows.
constexpr double kMinFraction = 0.25;
/// Pairs of means that a variance takes, and key frames that the longest means have to cover to
/// show what neighbours share.
constexpr std::size_t kMinPairs = 8;
constexpr std::size_t kMinLongestMean = 16;
/// Length of the mean heading, of one where the vehicle never turns: a slanting mount shows only
/// where it does.
constexpr double kMaxMeanHeadingLength = 0.7;

using Directions = std::vector<Eigen::Vector3d>;

/// Where the IMU has the sky in odometry's axes, by segment: the same everywhere but for errors.
std::vector<Directions> verticals_in_odometry(const DriveGraph& drive) {
  std::vector<Directions> result(drive.in_enu.size());
  for (const DriveImu& imu : drive.imu) {
    if (!imu.sample.orientation) continue;
    const DriveNode& node = drive.nodes[static_cast<std::size_t>(imu.node)];
    const Eigen::Quaterniond R_odom_world =
        node.T_odom_base.rotation * imu.sample.orientation->conjugate();
    result[static_cast<std::size_t>(node.segment)].push_back(R_odom_world *
                                                             Eigen::Vector3d::UnitZ());
  }
  return result;
}

/// Half the mean square of the change from one mean of `length` values to the next, per component.
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

/// Whether anything but odometry holds the height. Otherwise a firmer tilt's noise adds up along
/// the way, where odometry that comes back to a place knows its height again.
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

double tilt_stddev_deg(const DriveGraph& drive, const BackEndConfig& config) {
  const double configured = config.imu_orientation_stddev_deg;
  if (!is_height_constrained(drive, config) || !vehicle_turns(drive)) return configured;
  const std::vector<Directions> segments = verticals_in_odometry(drive);
  double variance = 0.0;  // of one value, if as many independent ones had the means' variance
  std::size_t length = 1;
  for (;; length *= 2) {
    AllanVariance of_means;
    for (const Directions& directions : segments) of_means.add(directions, length);
    if (of_means.pairs < kMinPairs) break;
    variance = std::max(variance, static_cast<double>(length) * of_means.value());
  }
  if (length <= kMinLongestMean) return configured;
  return std::clamp(std::sqrt(variance) * kDegPerRad, kMinFraction * configured, configured);
}

}  // namespace lidar_mapping::back_end
