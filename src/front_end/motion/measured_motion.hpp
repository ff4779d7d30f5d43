// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/motion_prior.hpp"

#include "motion/motion_filter.hpp"
#include "motion/velocity_validator.hpp"

namespace lidar_mapping::front_end {

/// Applies the motion measured by other sensors to the filter's prediction, weighted by the
/// accuracy that they have shown so far.
class MeasuredMotion {
 public:
  /// Applies angular rate and velocity; the velocity is weighted as one that may have become wrong
  /// just now.
  void apply(const MotionPrior& prior, MotionFilter& filter) const;
  /// The filter's belief after applying the measured velocity with its usual accuracy.
  registration::MotionBelief belief_with_velocity(const MotionPrior& prior,
                                                  MotionFilter filter) const;
  /// Learns from a velocity (m/s, sensor axes) that a match observed in all directions.
  void update(const MotionPrior& prior, const Eigen::Vector3d& true_velocity);

 private:
  VelocityValidator validator_;
};

}  // namespace lidar_mapping::front_end
