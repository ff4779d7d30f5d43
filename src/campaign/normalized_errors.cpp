// SPDX-License-Identifier: BSD-3-Clause
#include "normalized_errors.hpp"

#include <Eigen/Cholesky>

namespace lidar_mapping::campaign {

void NormalizedErrors::add(const Pose& truth, const Pose& claim, const Covariance6& covariance) {
  const Vector6d error = difference(claim, truth);
  sum_ += error.dot(covariance.ldlt().solve(error)) / 6.0;
  ++count_;
}

std::optional<double> NormalizedErrors::mean() const {
  if (count_ == 0) return std::nullopt;
  return sum_ / static_cast<double>(count_);
}

void MotionErrors::add(const front_end::FrontEndResult& result, const Pose& T_map_base) {
  const Known known{result.segment, T_map_base, result.T_odom_base};
  if (last_scan_ && last_scan_->segment == known.segment &&
      result.status.state == front_end::TrackingState::kTracking) {
    steps_.add(last_scan_->truth.inverse() * known.truth, last_scan_->claim.inverse() * known.claim,
               result.covariance);
  }
  last_scan_ = known;
  if (result.key_frame) add_edge(*result.key_frame, known);
}

void MotionErrors::add_edge(const KeyFrame& key_frame, const Known& known) {
  if (last_key_frame_ && last_key_frame_->segment == known.segment && !key_frame.doubtful &&
      key_frame.degenerate_directions.empty()) {
    edges_.add(last_key_frame_->truth.inverse() * known.truth,
               last_key_frame_->claim.inverse() * known.claim, key_frame.motion_covariance);
  }
  last_key_frame_ = known;
}

}  // namespace lidar_mapping::campaign
