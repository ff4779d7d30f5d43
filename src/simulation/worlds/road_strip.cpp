// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/road_strip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kStripStep = 2.0;         ///< m along the road; chosen: smaller ones slow the rays
constexpr double kMeadowCell = 2.0;        ///< m; chosen, as above
constexpr double kMeadowDepth = 0.12;      ///< Of the mean grass below the road, m; chosen: a verge
constexpr double kMeadowRoughness = 0.03;  ///< Standard deviation, m; chosen as of short grass

}  // namespace

Eigen::Vector2d beside(const Path& path, double station, double left) {
  const double heading = path.heading(station);
  return path.position(station) + left * Eigen::Vector2d(-std::sin(heading), std::cos(heading));
}

double distance_to(const Path& path, const Eigen::Vector2d& at) {
  double nearest = std::numeric_limits<double>::max();
  for (double s = 0.0; s <= path.length(); s += 1.0) {
    nearest = std::min(nearest, (path.position(s) - at).norm());
  }
  return nearest;
}

Path reversed(const Path& path, double left) {
  std::vector<Eigen::Vector2d> points;
  for (double s = path.length(); s >= 0.0; s -= Path::kSpacing) {
    points.push_back(beside(path, s, left));
  }
  return Path(std::move(points));
}

void add_road_strip(TriangleMesh& mesh, const Terrain& terrain, const Path& path, double left,
                    double half_width) {
  constexpr int kLanes = 4;  // strips side by side; chosen so that the road follows slopes across
  const auto at = [&](double s, int lane) -> Eigen::Vector3d {
    const double across = left + half_width * (2.0 * lane / kLanes - 1.0);
    return terrain.on_ground(beside(path, s, across));
  };
  for (double s = 0.0; s < path.length(); s += kStripStep) {
    const double next = std::min(s + kStripStep, path.length());
    for (int lane = 0; lane < kLanes; ++lane) {
      add_quad(mesh, at(s, lane), at(next, lane), at(next, lane + 1), at(s, lane + 1), kAsphalt);
    }
  }
}

void add_meadow(TriangleMesh& mesh, const Terrain& terrain, const Eigen::Vector2d& low,
                const Eigen::Vector2d& high, Random random) {
  const int nx = static_cast<int>((high.x() - low.x()) / kMeadowCell);
  const int ny = static_cast<int>((high.y() - low.y()) / kMeadowCell);
  const std::uint64_t seed = random.bits();
  const auto at = [&](int i, int j) -> Eigen::Vector3d {
    Random own(seed, static_cast<std::uint64_t>(j) * 100000U + static_cast<std::uint64_t>(i));
    return terrain.on_ground(low + kMeadowCell * Eigen::Vector2d(i, j),
                             kMeadowRoughness * own.normal() - kMeadowDepth);
  };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      add_quad(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), kGrass);
    }
  }
}

}  // namespace lidar_mapping::simulation
