// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/covariance_inflation.hpp"

namespace lidar_mapping::front_end {

bool is_doubtful(const FrontEndStatus& status) { return status.state == TrackingState::kDoubtful; }

Covariance6 expected_error_covariance(const FrontEndStatus& status) {
  return diagonal_covariance(status.expected_error, status.expected_error_angle);
}

void CovarianceInflation::add_step(const Pose& T_from_to, const FrontEndStatus& status) {
  const bool doubtful = is_doubtful(status);
  if (!inflated_ && !doubtful) return;
  inflated_ = true;
  const Covariance6 of_step = doubtful ? expected_error_covariance(status) : Covariance6::Zero();
  covariance_ = compose_covariance(covariance_, T_from_to, of_step);
}

void CovarianceInflation::apply_to(KeyFrame& key_frame) const {
  key_frame.doubtful = inflated_;
  if (inflated_) key_frame.motion_covariance += covariance_;
}

}  // namespace lidar_mapping::front_end
