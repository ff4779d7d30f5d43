// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/evaluation/association.hpp"

namespace lidar_mapping::tools {

/// What was done to the estimate already, and should not be proposed again.
struct AppliedOptions {
  bool alignment = false;
  bool lever_arm = false;
  bool lever_rotation = false;
};

/// Options of evaluate_trajectory that would take most of the error away: a truth that lies in
/// another frame or was measured elsewhere on the vehicle is no error of the estimate. A sentence
/// each; none where there is little to gain.
std::vector<std::string> trajectory_hints(const std::vector<evaluation::PosePair>& pairs,
                                          const AppliedOptions& applied);

}  // namespace lidar_mapping::tools
