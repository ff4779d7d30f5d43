// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/prior_of.hpp"

#include <utility>

namespace lidar_mapping::front_end {

MotionPrior prior_of(const std::optional<ImuSample>& imu,
                     const std::optional<VelocitySample>& velocity,
                     std::optional<UnevenTurning> uneven_turning,
                     const std::optional<FeltForce>& felt,
                     std::optional<std::uint64_t> fingerprint) {
  MotionPrior prior;
  if (imu && imu->has_angular_velocity) prior.angular_velocity = imu->angular_velocity;
  if (velocity) {
    prior.linear_velocity = velocity->linear;
    if (!velocity->angular.isZero(0.0)) prior.velocity_turning = velocity->angular;
  }
  prior.uneven_turning = std::move(uneven_turning);
  prior.felt = felt;
  prior.fingerprint = fingerprint;
  return prior;
}

}  // namespace lidar_mapping::front_end
