// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Follows an external odometry (`odometry: external`) instead of matching the scans.
class ExternalTracker : public Tracker {
 public:
  /// Throws InputError if the prior has no T_external_base.
  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  Covariance6 covariance_of_step(const TrackedScan& from, const TrackedScan& to) const override;
  void restart() override { T_first_external_.reset(); }
  PointCloud local_map() const override { return {}; }

 private:
  std::optional<Pose> T_first_external_;
};

}  // namespace lidar_mapping::front_end
