// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"

namespace lidar_mapping::front_end {

/// True if the step to this scan may be off by more than its covariance says.
bool is_doubtful(const FrontEndStatus& status);

/// What such a step has on top of the covariance of its match: its expected error, in each
/// direction, as nobody knows where to.
Covariance6 expected_error_covariance(const FrontEndStatus& status);

/// Adds up what the doubtful steps of a motion have on top of the covariance of matches. Steps err
/// independently of each other; what one of them turned wrongly carries on over those after it.
class MotionDoubt {
 public:
  /// The next step of the motion, and how its end was judged.
  void add_step(const Pose& T_from_to, const FrontEndStatus& status);
  /// The motion leads to this key frame: it has the doubt, and all of it in its covariance.
  void apply_to(KeyFrame& key_frame) const;

  /// In the axes of where the motion has led; zero where no step was doubtful.
  const Covariance6& covariance() const { return covariance_; }
  bool has_doubt() const { return has_doubt_; }

 private:
  Covariance6 covariance_ = Covariance6::Zero();
  bool has_doubt_ = false;
};

}  // namespace lidar_mapping::front_end
