// SPDX-License-Identifier: BSD-3-Clause
#include "path_display.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// What lies nearer to the straight line between its neighbours is of no worth to the shape.
constexpr double kStraight = 0.001;  // m

double distance_to_line(const Eigen::Vector3d& point, const Eigen::Vector3d& begin,
                        const Eigen::Vector3d& end) {
  const Eigen::Vector3d line = end - begin;
  const double squared = line.squaredNorm();
  const double share =
      squared > 0.0 ? std::clamp((point - begin).dot(line) / squared, 0.0, 1.0) : 0.0;
  return (point - begin - share * line).norm();
}

/// A stretch of the path whose ends are in the outline, and what the worthier of them is worth.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
  double worth = std::numeric_limits<double>::infinity();
};

/// By how much the outline would miss each pose if it were left out; never more than what the pose
/// is worth at which the stretch around it begins.
std::vector<double> worth_of(const std::vector<KeyFramePose>& poses) {
  std::vector<double> worth(poses.size(), 0.0);
  worth.front() = worth.back() = std::numeric_limits<double>::infinity();
  std::vector<Stretch> open = {{0, poses.size() - 1}};
  while (!open.empty()) {
    const Stretch stretch = open.back();
    open.pop_back();
    std::size_t farthest = stretch.begin;
    double largest = kStraight;
    for (std::size_t i = stretch.begin + 1; i < stretch.end; ++i) {
      const double distance = distance_to_line(poses[i].T_map_base.translation,
                                               poses[stretch.begin].T_map_base.translation,
                                               poses[stretch.end].T_map_base.translation);
      if (distance <= largest) continue;
      largest = distance;
      farthest = i;
    }
    if (farthest == stretch.begin) continue;
    worth[farthest] = std::min(stretch.worth, largest);
    open.push_back({stretch.begin, farthest, worth[farthest]});
    open.push_back({farthest, stretch.end, worth[farthest]});
  }
  return worth;
}

/// Positions of the poses that stay, in order.
std::vector<std::size_t> outline(const std::vector<KeyFramePose>& poses, std::size_t limit) {
  std::vector<std::size_t> kept(poses.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i;
  if (kept.size() <= limit) return kept;
  const std::vector<double> worth = worth_of(poses);
  const auto end = kept.begin() + static_cast<std::ptrdiff_t>(limit);
  std::nth_element(kept.begin(), end, kept.end(), [&](std::size_t a, std::size_t b) {
    return worth[a] != worth[b] ? worth[a] > worth[b] : a < b;
  });
  kept.erase(end, kept.end());
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

nav_msgs::Path to_path(const KeyFramePoses& poses, const std::string& frame, std::size_t limit) {
  nav_msgs::Path path;
  path.header.frame_id = frame;
  for (const std::size_t i : outline(poses.poses, limit)) {
    geometry_msgs::PoseStamped stamped;
    stamped.header.frame_id = frame;
    stamped.header.stamp = to_ros(poses.poses[i].stamp);
    stamped.pose = to_message(poses.poses[i].T_map_base);
    path.poses.push_back(stamped);
  }
  if (!path.poses.empty()) path.header.stamp = path.poses.back().header.stamp;
  return path;
}

}  // namespace lidar_mapping::ros_border
