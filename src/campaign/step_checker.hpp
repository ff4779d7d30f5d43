// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"
#include "lidar_mapping/front_end/wrong_step.hpp"

namespace lidar_mapping::campaign {

/// Error of a step from the last scan that claimed its pose.
struct StepError {
  double metres = 0.0;
  double degrees = 0.0;

  /// By the definition that the model of the front end is fitted with.
  bool is_wrong() const {
    return metres > front_end::kWrongStep || degrees * kRadPerDeg > front_end::kWrongStepAngle;
  }
};

/// One step: the claimed status and the true error.
struct CheckedStep {
  Stamp stamp = 0;
  front_end::FrontEndStatus status;
  StepError error;

  /// Within three of its own standard deviations.
  bool is_right() const;
};

/// How often a status and the truth about a step agree or not.
struct StepCounts {
  std::size_t silent = 0;          ///< steps that are wrong though called tracking
  std::size_t wrong = 0;           ///< steps that are wrong, whatever they are called
  std::size_t false_alarms = 0;    ///< steps that are not wrong, but called doubtful or worse
  double largest_error = 0.0;      ///< m, of a step that is called tracking
  double largest_error_deg = 0.0;  ///< likewise
};

/// Counts wrong steps that the status calls right. A step leads from the last scan that was neither
/// lost nor degraded, because a guess in between claims nothing.
class StepChecker {
 public:
  /// Adds the pose of the next scan with its state; `new_segment` is true where the poses before
  /// are not connected to it. Returns the error of the step that ends there; empty if none does.
  std::optional<StepError> add(const Pose& T_map_base, const Pose& T_odom_base,
                               front_end::TrackingState state, bool new_segment);
  const StepCounts& counts() const { return counts_; }

 private:
  void count(const StepError& error, front_end::TrackingState state);

  struct Claim {
    Pose T_map_base;
    Pose T_odom_base;
  };
  std::optional<Claim> last_;
  StepCounts counts_;
};

}  // namespace lidar_mapping::campaign
