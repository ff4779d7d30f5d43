// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/step_evidence.hpp"

namespace lidar_mapping::front_end {

/// A step that is off by more than this is wrong, whatever its covariance says.
constexpr double kWrongStep = 0.3;                   // m
constexpr double kWrongStepAngle = 0.0174532925199;  // rad, 1 degree

/// Which evidence there is: the sequential NDT has all of it, other methods have less.
enum class EvidenceSource { kNdt, kSlidingWindow };

/// What the evidence says of a step, by models that are fitted to simulated drives with and without
/// faults (scripts/fit_step_belief.py, doc/campaign.md). They learn nothing while they run.
struct StepBelief {
  double probability = 1.0;  ///< that it is right within three of its own standard deviations
  /// How far off such steps usually are, whatever their covariance says.
  double expected_error = 0.0;        ///< m
  double expected_error_angle = 0.0;  ///< rad
  /// The probability that it is off by less than kWrongStep and kWrongStepAngle.
  double safety = 1.0;

  /// False if calling it tracked is a worse bet than doubting it; `in_doubt` if the step before was
  /// doubted.
  bool is_safe(bool in_doubt) const;
};

StepBelief evaluate_step(const StepEvidence& evidence, EvidenceSource source);

/// Takes beliefs into the status: their probability and expected error, and a state that claims no
/// more than that. Of the steps before it remembers only whether the last one was doubted.
class DoubtState {
 public:
  void apply(const StepBelief& belief, FrontEndStatus& status);
  /// With a new map.
  void reset();

 private:
  bool in_doubt_ = false;
};

}  // namespace lidar_mapping::front_end
