// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/back_end/pose_change.hpp"

namespace lidar_mapping::back_end {

PoseChange change_between(const KeyFramePoses& before, const KeyFramePoses& after) {
  PoseChange change;
  double sum = 0.0;
  auto old = before.poses.begin();
  for (const KeyFramePose& pose : after.poses) {
    while (old != before.poses.end() && old->index < pose.index) ++old;
    if (old == before.poses.end() || old->index != pose.index) continue;
    const double distance = (pose.T_map_base.translation - old->T_map_base.translation).norm();
    sum += distance;
    ++change.key_frames;
    if (distance <= change.largest && change.key_frames > 1) continue;
    change.largest = distance;
    change.farthest = pose.index;
    change.stamp = pose.stamp;
  }
  if (change.key_frames > 0) change.mean = sum / static_cast<double>(change.key_frames);
  return change;
}

}  // namespace lidar_mapping::back_end
