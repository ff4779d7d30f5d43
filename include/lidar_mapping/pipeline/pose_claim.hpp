// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::pipeline {

/// The pose in the map that somebody claims of a scan, until there is a map: odometry carries it
/// along with the scans that come meanwhile. One thread calls it.
class PoseClaim {
 public:
  /// Claims that T_map_base is the pose of the next scan; it replaces an earlier claim.
  void set(const Pose& T_map_base) {
    T_map_base_ = T_map_base;
    has_scan_ = false;
  }
  /// Carries the claim to the next scan. Returns false if there was one and it is dropped, because
  /// odometry does not lead from its scan to this one.
  bool carry_to(const localization::LocalizerInput& next);
  /// Gives the claimed pose of the newest scan once; none if nothing is claimed.
  std::optional<Pose> take();

 private:
  std::optional<Pose> T_map_base_;
  bool has_scan_ = false;  ///< The pose is that of the newest scan, and not of the next one.
};

}  // namespace lidar_mapping::pipeline
