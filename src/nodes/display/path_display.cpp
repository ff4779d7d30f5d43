// SPDX-License-Identifier: BSD-3-Clause
#include "display/path_display.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Points nearer to the line between their neighbours are not needed, m (chosen: far below what
/// rviz can show).
constexpr double kStraight = 0.001;

double distance_to_line(const Eigen::Vector3d& point, const Eigen::Vector3d& begin,
                        const Eigen::Vector3d& end) {
  const Eigen::Vector3d line = end - begin;
  const double squared = line.squaredNorm();
  const double fraction =
      squared > 0.0 ? std::clamp((point - begin).dot(line) / squared, 0.0, 1.0) : 0.0;
  return (point - begin - fraction * line).norm();
}

/// A section between two points of the simplified path, and the smaller importance of its ends.
struct Section {
  std::size_t begin = 0;
  std::size_t end = 0;
  double importance = std::numeric_limits<double>::infinity();
};

/// The distance of each pose from the line of its section at which it is added (Douglas and Peucker
/// 1973), limited by that of the ends of the section.
std::vector<double> importances_of(const std::vector<KeyFramePose>& poses) {
  std::vector<double> importances(poses.size(), 0.0);
  importances.front() = importances.back() = std::numeric_limits<double>::infinity();
  std::vector<Section> open = {{0, poses.size() - 1}};
  while (!open.empty()) {
    const Section section = open.back();
    open.pop_back();
    std::size_t farthest = section.begin;
    double largest = kStraight;
    for (std::size_t i = section.begin + 1; i < section.end; ++i) {
      const double distance = distance_to_line(poses[i].T_map_base.translation,
                                               poses[section.begin].T_map_base.translation,
                                               poses[section.end].T_map_base.translation);
      if (distance <= largest) continue;
      largest = distance;
      farthest = i;
    }
    if (farthest == section.begin) continue;
    importances[farthest] = std::min(section.importance, largest);
    open.push_back({section.begin, farthest, importances[farthest]});
    open.push_back({farthest, section.end, importances[farthest]});
  }
  return importances;
}

/// Positions of the poses of the simplified path, in order.
std::vector<std::size_t> simplified(const std::vector<KeyFramePose>& poses, std::size_t limit) {
  std::vector<std::size_t> kept(poses.size());
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i;
  if (kept.size() <= limit) return kept;
  const std::vector<double> importances = importances_of(poses);
  const auto end = kept.begin() + static_cast<std::ptrdiff_t>(limit);
  std::nth_element(kept.begin(), end, kept.end(), [&](std::size_t a, std::size_t b) {
    return importances[a] != importances[b] ? importances[a] > importances[b] : a < b;
  });
  kept.erase(end, kept.end());
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

nav_msgs::Path to_path(const KeyFramePoses& poses, const std::string& frame, std::size_t limit) {
  nav_msgs::Path path;
  path.header.frame_id = frame;
  for (const std::size_t i : simplified(poses.poses, limit)) {
    geometry_msgs::PoseStamped stamped;
    stamped.header = header_of(poses.poses[i].stamp, frame);
    stamped.pose = to_message(poses.poses[i].T_map_base);
    path.poses.push_back(stamped);
  }
  if (!path.poses.empty()) path.header.stamp = path.poses.back().header.stamp;
  return path;
}

}  // namespace lidar_mapping::ros_border
