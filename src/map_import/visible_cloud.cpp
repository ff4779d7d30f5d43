// SPDX-License-Identifier: BSD-3-Clause
#include "visible_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/fast_angle.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::map_import {

namespace {

// Pixels over a turn and over half a turn, of half a degree. Chosen: as dense as a LiDAR of 64
// beams sees, and finer than the cells of FreeSpaceImage (1.5 by 2 degrees).
constexpr int kColumns = 720;
constexpr int kRows = 360;
constexpr auto kHalfTurn = static_cast<float>(kPi);  // rad
constexpr float kPixel = kHalfTurn / kRows;          // rad, by the number of rows
constexpr float kEmpty = std::numeric_limits<float>::infinity();
// m from the LiDAR. Chosen: nearer is what the map has kept of the vehicle that made it.
constexpr float kNearest = 1.5F;
// m behind the nearest point of a direction, within which points are of one surface and averaged.
// Chosen: the noise of a map, less than a car is deep.
constexpr float kSurface = 0.3F;
// m. What lies so much behind the points beside it is seen through a surface. Chosen: more than a
// corner recedes between two points of a thinned map.
constexpr float kBehind = 0.5F;
// Pixels to which a surface is closed to one side. Chosen: those between two points 0.2 m apart at
// kNearest.
constexpr int kMostReach = 16;

/// A point in base_link, its direction and range from the LiDAR.
struct Ray {
  Point p_base;
  int pixel = 0;
  float range = 0.0F;
};

int pixel_of(const Eigen::Vector3f& ray) {
  const float elevation = fast_angle(ray.z(), ray.head<2>().norm());
  const float azimuth = fast_angle(ray.y(), ray.x());
  const int row = static_cast<int>((elevation / kHalfTurn + 0.5F) * kRows);
  const int column = static_cast<int>((azimuth / kHalfTurn + 1.0F) * 0.5F * kColumns);
  return std::clamp(row, 0, kRows - 1) * kColumns + std::clamp(column, 0, kColumns - 1);
}

std::vector<Ray> rays_to(const std::vector<PointTilePtr>& tiles, const Pose& T_map_base,
                         const Eigen::Vector3f& p_base_lidar) {
  constexpr auto kFarthest = static_cast<float>(kSight);  // m, see kSight in visible_cloud.hpp
  const Pose T_base_map = T_map_base.inverse();
  const Eigen::Matrix3f rotation = T_base_map.rotation_matrix().cast<float>();
  std::vector<Ray> rays;
  for (const PointTilePtr& tile : tiles) {
    const Eigen::Vector3f origin = (T_base_map * tile->origin).cast<float>();
    for (const Point& point : tile->cloud.points) {
      const Eigen::Vector3f p = rotation * point.position() + origin;
      const Eigen::Vector3f ray = p - p_base_lidar;
      const float range = ray.norm();
      if (!(range > kNearest && range < kFarthest)) continue;  // also not NaN
      rays.push_back({{p.x(), p.y(), p.z(), point.intensity}, pixel_of(ray), range});
    }
  }
  return rays;
}

/// The nearest range of each direction.
class NearestRanges {
 public:
  NearestRanges(const std::vector<Ray>& rays, double resolution)
      : ranges_(static_cast<std::size_t>(kRows * kColumns), kEmpty),
        reach_(static_cast<float>(resolution) / kPixel) {
    for (const Ray& ray : rays) {
      float& range = ranges_[static_cast<std::size_t>(ray.pixel)];
      range = std::min(range, ray.range);
    }
  }

  float at(int pixel) const { return ranges_[static_cast<std::size_t>(pixel)]; }

  /// Whether nearer points lie on two opposite sides of the nearest one of a direction, so close
  /// that they are of one surface.
  bool is_hidden(int pixel) const {
    const int row = pixel / kColumns;
    const int column = pixel % kColumns;
    const float limit = at(pixel) - kBehind;
    const auto has_nearer = [&](int rows, int columns) {
      for (int step = 1; step <= kMostReach; ++step) {
        const int r = row + step * rows;
        if (r < 0 || r >= kRows) return false;
        const int c = (column + step * columns + kColumns) % kColumns;
        const float range = at(r * kColumns + c);
        if (range < limit && static_cast<float>(step) * range <= reach_) return true;
      }
      return false;
    };
    return (has_nearer(0, 1) && has_nearer(0, -1)) || (has_nearer(1, 0) && has_nearer(-1, 0)) ||
           (has_nearer(1, 1) && has_nearer(-1, -1)) || (has_nearer(1, -1) && has_nearer(-1, 1));
  }

 private:
  std::vector<float> ranges_;
  float reach_;  ///< pixels times metres: the resolution seen from the range of a point
};

/// Sums of the points of a direction.
struct PixelSum {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float intensity = 0.0F;
  float count = 0.0F;
};

}  // namespace

PointCloud visible_cloud(const std::vector<PointTilePtr>& tiles, const Pose& T_map_base,
                         const Eigen::Vector3d& p_base_lidar, double resolution) {
  const std::vector<Ray> rays = rays_to(tiles, T_map_base, p_base_lidar.cast<float>());
  const NearestRanges nearest(rays, resolution);
  std::vector<PixelSum> sums(static_cast<std::size_t>(kRows * kColumns));
  for (const Ray& ray : rays) {
    if (ray.range > nearest.at(ray.pixel) + kSurface) continue;
    PixelSum& sum = sums[static_cast<std::size_t>(ray.pixel)];
    sum.position += ray.p_base.position();
    sum.intensity += ray.p_base.intensity;
    sum.count += 1.0F;
  }
  PointCloud cloud;
  for (int pixel = 0; pixel < kRows * kColumns; ++pixel) {
    const PixelSum& sum = sums[static_cast<std::size_t>(pixel)];
    if (sum.count == 0.0F || nearest.is_hidden(pixel)) continue;
    const Eigen::Vector3f p = sum.position / sum.count;
    cloud.points.push_back({p.x(), p.y(), p.z(), sum.intensity / sum.count});
  }
  return cloud;
}

}  // namespace lidar_mapping::map_import
