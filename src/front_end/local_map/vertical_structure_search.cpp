// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/vertical_structure_search.hpp"

#include "lidar_mapping/common/units.hpp"

#include "local_map/local_map.hpp"
#include "scan/displaced.hpp"

namespace lidar_mapping::front_end {
namespace {

/// About this number of points is compared. Chosen: bounds the time; a street has thousands.
constexpr std::size_t kMaxPoints = 400;
/// The points match in at least this number of 36 directions. Chosen: fewer may be one object.
constexpr int kMinDirections = 4;

// Search range (m); the direction of travel may be any of four directions of the sensor. Chosen: as
// far as in search_starts.cpp, by steps that the fit to voxels of 0.3 m converges from.
constexpr int kSearchDirections = 4;
constexpr double kSearchBehind = 2.4;
constexpr double kSearchAhead = 6.0;
constexpr double kSearchAside = 0.6;
constexpr double kSearchStep = 0.3;

/// Structures along the direction of travel fit equally well at this distance (m) ahead and behind;
/// they do not determine the pose. Chosen: twice the width of a match (0.3 m) and more.
constexpr double kDistinctDistance = 0.7;
/// A shorter displacement (m) or a slower motion (m/s) has no direction. Chosen: it is below the
/// error of a fitted pose.
constexpr double kMinDisplacement = 0.1;

}  // namespace

std::vector<Eigen::Vector3f> vertical_points_at(const SampledPoints& points,
                                                const Vector6d& twist) {
  SampledPoints transformed_points;
  transform_points(points, {Pose{}, twist}, Eigen::Vector3d::Zero(), transformed_points);
  return vertical_structure_points(transformed_points);
}

std::vector<Eigen::Vector3f> sampled_vertical_points_at(const SampledPoints& points,
                                                        const Vector6d& twist) {
  std::vector<Eigen::Vector3f> vertical = vertical_points_at(points, twist);
  const std::size_t stride = vertical.size() / kMaxPoints + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < vertical.size(); i += stride) vertical[kept++] = vertical[i];
  vertical.resize(kept);
  return vertical;
}

Eigen::Vector2d heading_of(const Vector6d& displacement) {
  const Eigen::Vector2d level = displacement.head<2>();
  return level.norm() < kMinDisplacement ? Eigen::Vector2d::UnitX() : level.normalized();
}

Pose coarse_search(const VerticalStructureMap& map, const std::vector<Eigen::Vector3f>& points,
                   const Pose& center) {
  Pose best = center;
  std::size_t best_count = 0;
  for (int direction = 0; direction < kSearchDirections; ++direction) {
    const Eigen::Rotation2Dd heading(2.0 * kPi / kSearchDirections * direction);
    for (double x = -kSearchBehind; x <= kSearchAhead + 1e-9; x += kSearchStep) {
      for (double y = -kSearchAside; y <= kSearchAside + 1e-9; y += kSearchStep) {
        const Pose candidate = displaced(center, heading * Eigen::Vector2d(x, y));
        const std::size_t points_near = map.count_near(points, candidate);
        if (points_near <= best_count) continue;
        best_count = points_near;
        best = candidate;
      }
    }
  }
  return best;
}

bool is_distinct(const VerticalStructureMap& map, const VerticalStructureMap::Fit& fit,
                 const Eigen::Vector2d& ahead, const std::vector<Eigen::Vector3f>& points) {
  const Pose& pose = fit.T_map_sensor;
  const int evidence_behind =
      map.evaluate(points, displaced(pose, -kDistinctDistance * ahead)).evidence;
  const int evidence_ahead =
      map.evaluate(points, displaced(pose, kDistinctDistance * ahead)).evidence;
  return fit.directions >= kMinDirections &&
         fit.evidence > kMinEvidenceRatio * 0.5 * (evidence_behind + evidence_ahead);
}

}  // namespace lidar_mapping::front_end
