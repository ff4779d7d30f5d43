// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/motion_prior.hpp"

#include "motion_filter.hpp"
#include "velocity_validator.hpp"

namespace lidar_mapping::front_end {

/// Takes what other sensors measured of the motion into the filter's prediction, as far as it has
/// deserved that so far.
class MeasuredMotion {
 public:
  /// Rate and velocity; the velocity as one that may have gone wrong just now.
  void apply(const MotionPrior& prior, MotionFilter& filter) const;
  /// The filter's belief, held to the measured velocity as firmly as it has deserved.
  registration::MotionBelief belief_with_velocity(const MotionPrior& prior,
                                                  MotionFilter filter) const;
  /// Takes in a velocity (m/s, own axes) that a match observed in all directions.
  void update(const MotionPrior& prior, const Eigen::Vector3d& true_velocity);

 private:
  VelocityValidator validator_;
};

}  // namespace lidar_mapping::front_end
