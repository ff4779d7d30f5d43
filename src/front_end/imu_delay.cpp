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
  information_ = kMemory * information_ + change.squaredNorm();
  product_ = kMemory * product_ + change.dot(error);
  squared_error_ = kMemory * squared_error_ + error.squaredNorm();
  weight_ = kMemory * weight_ + 1.0;
  if (weight_ < kFewestSteps || information_ <= 0.0) return;
  const double found = product_ / information_;
  const double residual = std::max(0.0, squared_error_ - found * product_) / (3.0 * weight_);
  const double sigma = std::sqrt(residual / information_);
  if (std::abs(found) < std::max(kLeastDelay, kCertain * sigma)) return;
  seconds_ = std::clamp(seconds_ + found, -kLargestDelay, kLargestDelay);
  // What was seen before belongs to the delay of before.
  information_ = product_ = squared_error_ = weight_ = 0.0;
}

}  // namespace lidar_mapping::front_end
