// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/front_end/front_end_status.hpp"

namespace lidar_mapping::front_end {

/// A warning about the input or the state of the odometry.
struct StatusWarning {
  std::string key;   ///< the same for all warnings of one kind
  std::string text;  ///< one sentence for people
};

/// Key of the warning that the local map is full; its text counts the points.
constexpr char kFullMapKey[] = "full map";

/// The warnings that follow from a status, without those about the match of this scan alone. Each
/// comes again with every scan for as long as its cause lasts; the caller limits them by their key.
std::vector<StatusWarning> warnings_of(const FrontEndStatus& status);

}  // namespace lidar_mapping::front_end
