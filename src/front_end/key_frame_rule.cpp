// SPDX-License-Identifier: BSD-3-Clause
#include "key_frame_rule.hpp"

namespace lidar_mapping::front_end {

bool KeyFrameRule::reached(const Pose& T_last_now, Stamp elapsed) const {
  return motion_reached(T_last_now) || (interval > 0.0 && to_seconds(elapsed) >= interval);
}

bool KeyFrameRule::motion_reached(const Pose& T_last_now) const {
  return T_last_now.translation.norm() >= distance || rotation_angle(T_last_now.rotation) >= angle;
}

}  // namespace lidar_mapping::front_end
