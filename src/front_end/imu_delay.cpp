#include "lidar_mapping/front_end/imu_delay.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Steps are forgotten to 1/e after 200 of them.
constexpr double kMemory = 0.995;
constexpr double kFewestSteps = 20.0;
/// A delay is believed from so many of its standard deviations on,
constexpr double kCertain = 5.0;
/// and from that size: less moves no point by more than the noise of the ranges, s.
constexpr double kLeastDelay = 5e-4;
/// Beyond that it cannot be told from other faults, s.
constexpr double kLargestDelay = 0.05;

}  // namespace

void ImuDelay::update(const Eigen::Vector3d& error, const Eigen::Vector3d& change) {
  const auto add = [](auto& sum, const auto& value) { sum = kMemory * sum + value; };
  add(sums_.weight, 1.0);
  add(sums_.error, error);
  add(sums_.change, change);
  add(sums_.squared_error, error.squaredNorm());
  add(sums_.squared_change, change.squaredNorm());
  add(sums_.product, change.dot(error));
  if (sums_.weight < kFewestSteps) return;
  const double information = sums_.squared_change - sums_.change.squaredNorm() / sums_.weight;
  if (information <= 0.0) return;
  const double product = sums_.product - sums_.change.dot(sums_.error) / sums_.weight;
  const double scatter = sums_.squared_error - sums_.error.squaredNorm() / sums_.weight;
  const double found = product / information;
  const double residual = std::max(0.0, scatter - found * product) / (3.0 * sums_.weight);
  const double sigma = std::sqrt(residual / information);
  if (std::abs(found) < std::max(kLeastDelay, kCertain * sigma)) return;
  seconds_ = std::clamp(seconds_ + found, -kLargestDelay, kLargestDelay);
  // What was seen before belongs to the delay of before.
  sums_ = {};
}

}  // namespace lidar_mapping::front_end
