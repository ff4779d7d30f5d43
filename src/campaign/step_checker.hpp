// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/front_end/front_end_status.hpp"

namespace lidar_mapping::campaign {

/// A step is wrong from here on.
constexpr double kWrongStep = 0.3;       // m
constexpr double kWrongStepAngle = 1.0;  // deg

/// How far off a step from the last scan that claimed its pose is.
struct StepError {
  double metres = 0.0;
  double degrees = 0.0;

  bool is_wrong() const { return metres > kWrongStep || degrees > kWrongStepAngle; }
};

/// One step: what was said of it, and what is true.
struct CheckedStep {
  Stamp stamp = 0;
  front_end::FrontEndStatus status;
  StepError error;

  /// Within three of its own standard deviations.
  bool is_right() const;
};

/// Tells wrong steps that are called right. A step leads from the last scan that was not called
/// lost or degraded: a guess in between claims nothing.
class StepChecker {
 public:
  /// The pose of the next scan and what was said of it, `new_segment` where the poses before do not
  /// hang together with it. Returns the error of the step that ends there, none where none does.
  std::optional<StepError> take(const Pose& T_map_base, const Pose& T_odom_base,
                                front_end::TrackingState state, bool new_segment);
  std::size_t silent() const { return silent_; }
  std::size_t wrong() const { return wrong_; }
  std::size_t false_alarms() const { return false_alarms_; }
  double largest_error() const { return largest_error_; }
  double largest_error_deg() const { return largest_error_deg_; }

 private:
  void count(const StepError& error, front_end::TrackingState state);

  struct Claim {
    Pose T_map_base;
    Pose T_odom_base;
  };
  std::optional<Claim> last_;
  std::size_t silent_ = 0;
  std::size_t wrong_ = 0;
  std::size_t false_alarms_ = 0;
  double largest_error_ = 0.0;
  double largest_error_deg_ = 0.0;
};

}  // namespace lidar_mapping::campaign
