// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"

namespace lidar_mapping::front_end {

/// True if the error of the step to this scan may be larger than its covariance tells.
bool is_doubtful(const FrontEndStatus& status);

/// Additional covariance of such a step: its expected error, in every direction, because the
/// direction of the error is not known.
Covariance6 expected_error_covariance(const FrontEndStatus& status);

/// Accumulates the additional covariance of the doubtful steps of a motion. The errors of the steps
/// are independent of each other; a rotation error of one step also displaces all later steps.
class CovarianceInflation {
 public:
  /// Adds the next step of the motion, with the status of its end.
  void add_step(const Pose& T_from_to, const FrontEndStatus& status);
  /// Applies the result to the key frame at the end of the motion: sets its doubt flag and
  /// increases its covariance.
  void apply_to(KeyFrame& key_frame) const;

  /// In the axes of the motion's end; zero if no step was doubtful.
  const Covariance6& covariance() const { return covariance_; }

 private:
  Covariance6 covariance_ = Covariance6::Zero();
  bool inflated_ = false;
};

}  // namespace lidar_mapping::front_end
