// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/front_end/step_evidence.hpp"

#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Covariance of the motion from one pose to the other, in the axes of the latter.
Covariance6 step_covariance(const PoseEstimate& from, const PoseEstimate& to);

/// The origin of the current step: the last scan whose pose was claimed to be correct. A step over
/// lost or degraded scans leads from the scan before them to the first one after them.
class StepOrigin {
 public:
  /// To be called for each scan, with the time since the previous one.
  void advance(double seconds) { elapsed_ += seconds; }
  /// Writes duration and standard deviations of the step from the origin to the present scan.
  void set_step_to(const PoseEstimate& estimate, StepEvidence& evidence) const;
  /// To be called at the end of each scan: it becomes the origin if its pose is claimed, or if a
  /// segment starts with it.
  void update(const TrackedScan& tracked);

 private:
  PoseEstimate estimate_;
  double elapsed_ = 0.0;  ///< s since the origin
};

}  // namespace lidar_mapping::front_end
