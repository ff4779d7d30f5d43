// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/path_simplification.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace lidar_mapping {

namespace {

/// Points nearer to the line between their neighbours are not needed, m (chosen: far below what a
/// display can show).
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
struct PathSection {
  std::size_t begin = 0;
  std::size_t end = 0;
  double importance = std::numeric_limits<double>::infinity();
};

/// The distance of each point from the line of its section at which it is added, limited by that of
/// the ends of the section.
std::vector<double> importances_of(const std::vector<Eigen::Vector3d>& path) {
  std::vector<double> importances(path.size(), 0.0);
  importances.front() = importances.back() = std::numeric_limits<double>::infinity();
  std::vector<PathSection> open = {{0, path.size() - 1}};
  while (!open.empty()) {
    const PathSection section = open.back();
    open.pop_back();
    std::size_t farthest = section.begin;
    double largest = kStraight;
    for (std::size_t i = section.begin + 1; i < section.end; ++i) {
      const double distance = distance_to_line(path[i], path[section.begin], path[section.end]);
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

}  // namespace

std::vector<std::size_t> simplified_path(const std::vector<Eigen::Vector3d>& path,
                                         std::size_t limit) {
  std::vector<std::size_t> kept(path.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  if (kept.size() <= limit) return kept;
  const std::vector<double> importances = importances_of(path);
  const auto end = kept.begin() + static_cast<std::ptrdiff_t>(limit);
  std::nth_element(kept.begin(), end, kept.end(), [&](std::size_t a, std::size_t b) {
    return importances[a] != importances[b] ? importances[a] > importances[b] : a < b;
  });
  kept.erase(end, kept.end());
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace lidar_mapping
