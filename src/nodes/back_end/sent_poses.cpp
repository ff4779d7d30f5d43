// SPDX-License-Identifier: BSD-3-Clause
#include "back_end/sent_poses.hpp"

#include <algorithm>

namespace lidar_mapping::ros_border {

namespace {

// m and rad: smaller moves are not sent. Chosen: by both together, a point 50 m away moves by 6 mm,
// an eighth of what changes the displayed map (rebuild_distance); loop closing needs less. What has
// to be exact, as a map on disk, is made of the poses of get_key_frames.
constexpr double kStep_m = 0.001;
constexpr double kStep_rad = 0.0001;

bool has_moved(const Pose& sent, const Pose& now) {
  const double distance = (now.translation - sent.translation).norm();
  const double angle = rotation_angle(sent.rotation.conjugate() * now.rotation);
  return !(distance < kStep_m && angle < kStep_rad);
}

}  // namespace

std::optional<KeyFramePoses> SentPoses::update(const KeyFramePoses& now, bool whole) {
  if (now.poses.empty()) return std::nullopt;
  if (whole || !is_continued_by(now)) {
    sent_ = now;
    return sent_;
  }
  // Such a message would count as outdated where the revision is known.
  if (now.revision == sent_.revision) return std::nullopt;
  KeyFramePoses part = take_changes(now);
  if (part.poses.empty()) return std::nullopt;
  sent_.revision = now.revision;
  if (part.poses.size() == now.poses.size()) return sent_;
  return part;
}

/// Whether key frames were at most added behind the known ones, as in every run.
bool SentPoses::is_continued_by(const KeyFramePoses& now) const {
  if (sent_.poses.empty() || now.poses.size() < sent_.poses.size()) return false;
  return std::equal(
      sent_.poses.begin(), sent_.poses.end(), now.poses.begin(),
      [](const KeyFramePose& a, const KeyFramePose& b) { return a.index == b.index; });
}

KeyFramePoses SentPoses::take_changes(const KeyFramePoses& now) {
  KeyFramePoses part;
  part.revision = now.revision;
  part.since = sent_.revision;
  part.whole = false;
  const std::size_t known = sent_.poses.size();
  for (std::size_t i = 0; i < known; ++i) {
    if (!has_moved(sent_.poses[i].T_map_base, now.poses[i].T_map_base)) continue;
    sent_.poses[i] = now.poses[i];
    part.poses.push_back(now.poses[i]);
  }
  const auto first_new = now.poses.begin() + static_cast<std::ptrdiff_t>(known);
  sent_.poses.insert(sent_.poses.end(), first_new, now.poses.end());
  part.poses.insert(part.poses.end(), first_new, now.poses.end());
  return part;
}

}  // namespace lidar_mapping::ros_border
