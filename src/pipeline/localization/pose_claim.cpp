// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/pose_claim.hpp"

#include <utility>

namespace lidar_mapping::pipeline {

bool PoseClaim::carry_to(const localization::LocalizerInput& next) {
  const bool is_of_earlier_scan = std::exchange(has_scan_, true);
  if (!T_map_base_ || !is_of_earlier_scan) return true;
  if (next.is_connected) {
    T_map_base_ = *T_map_base_ * next.T_previous_base;
    return true;
  }
  T_map_base_.reset();
  return false;
}

std::optional<Pose> PoseClaim::take() { return std::exchange(T_map_base_, std::nullopt); }

}  // namespace lidar_mapping::pipeline
