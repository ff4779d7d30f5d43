// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/evaluation/association.hpp"

namespace lidar_mapping::tools {

/// Options that were applied to the estimate already, and are not proposed again.
struct AppliedOptions {
  bool alignment = false;
  bool lever_arm = false;
  bool lever_rotation = false;
};

/// Options of evaluate_trajectory that would remove most of the error, a sentence each: a truth in
/// another frame or of another point of the vehicle is no error of the estimate. Empty if there is
/// little to gain.
std::vector<std::string> trajectory_hints(const std::vector<evaluation::PosePair>& pairs,
                                          const AppliedOptions& applied);

}  // namespace lidar_mapping::tools
