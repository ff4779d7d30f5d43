// SPDX-License-Identifier: BSD-3-Clause
#include "motion/gyro_bias.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Chosen: a second holds several periods of the vibration of an engine, and a stop is longer.
constexpr Stamp kWindow = from_seconds(1.0);
constexpr std::size_t kMinSamples = 8;  // per window, 8 Hz; chosen: fewer say little of the scatter
/// One estimate per second. Chosen: this is more than a minute, longer than any scan waits.
constexpr std::size_t kMaxEstimates = 64;
// rad/s, standard deviation: above the noise of MEMS gyros with an engine running, below that of a
// vehicle in motion. Chosen.
constexpr double kMaxRateDeviation = 0.01;
// m/s^2, standard deviation, chosen in the same way; engines shake more.
constexpr double kMaxAccelerationDeviation = 0.15;
// rad/s (3 degrees/s) if the velocity confirms the standstill. Chosen: MEMS gyros have less.
constexpr double kMaxBias = 0.05;
// rad/s without a velocity. Chosen: in a wide bend the vehicle turns as slowly (10 m/s on a radius
// of 500 m).
constexpr double kMaxBiasWithoutVelocity = 0.02;

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double deviation = 0.0;
};

Moments moments(const std::deque<ImuSample>& window, Eigen::Vector3d ImuSample::*value) {
  Moments result;
  for (const ImuSample& sample : window) result.mean += sample.*value;
  result.mean /= static_cast<double>(window.size());
  double sum = 0.0;
  for (const ImuSample& sample : window) sum += (sample.*value - result.mean).squaredNorm();
  result.deviation = std::sqrt(sum / static_cast<double>(3 * window.size()));
  return result;
}

}  // namespace

void GyroBias::add(const ImuSample& sample, std::optional<bool> standing) {
  if (!window_.empty() && sample.stamp <= window_.back().stamp) window_.clear();
  window_.push_back(sample);
  if (sample.stamp - window_.front().stamp < kWindow) return;
  update(standing);
  window_.clear();
}

void GyroBias::update(std::optional<bool> standing) {
  if (window_.size() < kMinSamples || (standing && !*standing)) return;
  const Moments rate = moments(window_, &ImuSample::angular_velocity);
  const Moments acceleration = moments(window_, &ImuSample::linear_acceleration);
  const double max_bias = standing ? kMaxBias : kMaxBiasWithoutVelocity;
  if (rate.deviation > kMaxRateDeviation || acceleration.deviation > kMaxAccelerationDeviation ||
      rate.mean.norm() > max_bias) {
    return;
  }
  // A bias drifts over minutes: a window of one second has a weight of a quarter.
  const Eigen::Vector3d bias =
      estimates_.empty() ? rate.mean
                         : Eigen::Vector3d(0.75 * estimates_.back().bias + 0.25 * rate.mean);
  estimates_.push_back({window_.back().stamp, bias});
  if (estimates_.size() > kMaxEstimates) estimates_.pop_front();
}

Eigen::Vector3d GyroBias::at(Stamp stamp) const {
  for (auto estimate = estimates_.rbegin(); estimate != estimates_.rend(); ++estimate) {
    if (estimate->stamp <= stamp) return estimate->bias;
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace lidar_mapping::preprocessing
