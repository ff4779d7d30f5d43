// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::tools {

/// What localize_bag keeps of a scan.
struct LocalizedScan {
  localization::LocalizationResult result;
  Pose T_odom_base;           ///< by odometry
  std::uint32_t segment = 0;  ///< odometry leads from scan to scan within one
  double path = 0.0;          ///< by odometry since the first scan, m
  double seconds = 0.0;       ///< processor time of its localisation; differs from run to run
};

}  // namespace lidar_mapping::tools
