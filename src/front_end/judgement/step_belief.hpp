// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/step_evidence.hpp"
#include "lidar_mapping/front_end/wrong_step.hpp"

namespace lidar_mapping::front_end {

/// The source of the evidence: the sequential NDT gives all figures, other methods give fewer.
enum class EvidenceSource { kNdt, kSlidingWindow };

/// Probabilities and expected errors of a step, computed from the evidence by models that are
/// fitted to simulated drives with and without faults (scripts/fit_step_belief.py,
/// doc/campaign.md). The models do not change while the program runs.
struct StepBelief {
  /// that the step is correct within three of its own standard deviations
  double probability = 1.0;
  /// Usual error of such steps, independent of their covariance.
  double expected_error = 0.0;        ///< m
  double expected_error_angle = 0.0;  ///< rad
  /// The probability that the error is less than kWrongStep and kWrongStepAngle.
  double safety = 1.0;

  /// True if the expected cost of calling the step tracked is lower than that of calling it
  /// doubtful; `in_doubt` tells whether the previous step was called doubtful.
  bool is_safe(bool in_doubt) const;
};

StepBelief evaluate_step(const StepEvidence& evidence, EvidenceSource source);

/// Writes beliefs into the status: probability, expected error, and a state that claims no more
/// than the belief allows. Of the previous steps it stores only whether the last one was doubtful.
class DoubtState {
 public:
  void apply(const StepBelief& belief, FrontEndStatus& status);
  /// To be called with a new map.
  void reset() { in_doubt_ = false; }

 private:
  bool in_doubt_ = false;
};

}  // namespace lidar_mapping::front_end
