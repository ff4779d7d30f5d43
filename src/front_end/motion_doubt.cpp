// SPDX-License-Identifier: BSD-3-Clause
#include "motion_doubt.hpp"

namespace lidar_mapping::front_end {

bool is_doubtful(const FrontEndStatus& status) { return status.state == TrackingState::kDoubtful; }

Covariance6 expected_error_covariance(const FrontEndStatus& status) {
  return diagonal_covariance(status.expected_error, status.expected_error_angle);
}

void MotionDoubt::add_step(const Pose& T_from_to, const FrontEndStatus& status) {
  const bool doubtful = is_doubtful(status);
  if (!has_doubt_ && !doubtful) return;
  has_doubt_ = true;
  const Covariance6 of_step = doubtful ? expected_error_covariance(status) : Covariance6::Zero();
  covariance_ = compose_covariance(covariance_, T_from_to, of_step);
}

void MotionDoubt::apply_to(KeyFrame& key_frame) const {
  key_frame.doubtful = has_doubt_;
  if (has_doubt_) key_frame.motion_covariance += covariance_;
}

}  // namespace lidar_mapping::front_end
