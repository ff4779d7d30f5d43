// SPDX-License-Identifier: BSD-3-Clause
#include "visible_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/spherical_projection.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::map_import {

namespace {

// Pixels over a turn and over half a turn, of half a degree. Chosen: as dense as a LiDAR of 64
// beams sees, and finer than the cells of FreeSpaceImage (1.5 by 2 degrees).
constexpr int kColumns = 720;
constexpr int kRows = 360;
constexpr float kPixel = kPiFloat / kRows;  // rad, by the number of rows
constexpr float kEmpty = std::numeric_limits<float>::infinity();
// m from the LiDAR. Chosen: nearer is what the map has kept of the vehicle that made it.
constexpr float kNearest = 0.3F;
// Sine of 60 degrees of elevation. Chosen: LiDARs of vehicles do not look steeper, and pixels are
// narrow there.
constexpr float kSteepest = 0.866F;
// Resolutions of the map, from a ray to points of a surface that it would pass. Chosen: in a circle
// of this radius a surface has seven points.
constexpr float kReach = 1.5F;
// m beyond the resolution, behind a surface, from which on a point is not on it. Chosen: the noise
// of a map; a corner recedes by the resolution between two points of its sides, and slabs and walls
// of 0.3 m have two sides.
constexpr float kNoise = 0.05F;
// Eighths of a turn beside each other. Chosen: the directions of the points in the others are then
// less than half a turn apart, so that these lie around the ray.
constexpr int kOpenEighths = 2;

/// A point in base_link, its direction and range from the LiDAR.
struct Ray {
  Point p_base;
  int pixel = 0;
  float range = 0.0F;
  bool is_steep = false;  ///< it hides others, but is not seen
};

int pixel_of(const Eigen::Vector3f& ray) {
  const SphericalPixel pixel = spherical_pixel(ray, kRows, kColumns);
  return pixel.row * kColumns + pixel.column;
}

std::vector<Ray> rays_to(const std::vector<PointTilePtr>& tiles, const Pose& T_map_base,
                         const Eigen::Vector3f& p_base_lidar) {
  constexpr auto kFarthest = static_cast<float>(kSight);  // m, see kSight in visible_cloud.hpp
  const Pose T_base_map = T_map_base.inverse();
  const Eigen::Matrix3f rotation = T_base_map.rotation_matrix().cast<float>();
  std::vector<Ray> rays;
  std::size_t most = 0;
  for (const PointTilePtr& tile : tiles) most += tile->cloud.size();
  rays.reserve(most);
  for (const PointTilePtr& tile : tiles) {
    const Eigen::Vector3f origin = (T_base_map * tile->origin).cast<float>();
    for (const Point& point : tile->cloud.points) {
      const Eigen::Vector3f p = rotation * point.position() + origin;
      const Eigen::Vector3f ray = p - p_base_lidar;
      const float range = ray.norm();
      if (!(range > kNearest && range < kFarthest)) continue;  // also not NaN
      const bool is_steep = std::abs(ray.z()) > kSteepest * range;
      rays.push_back({{p.x(), p.y(), p.z(), point.intensity}, pixel_of(ray), range, is_steep});
    }
  }
  return rays;
}

using Image = std::vector<float>;  // ranges, row by row; kEmpty where there is no point

std::size_t at(int row, int column) {
  return static_cast<std::size_t>(row * kColumns + (column + kColumns) % kColumns);
}

Image nearest_ranges(const std::vector<Ray>& rays) {
  Image nearest(static_cast<std::size_t>(kRows * kColumns), kEmpty);
  for (const Ray& ray : rays) {
    float& range = nearest[ray.pixel];
    range = std::min(range, ray.range);
  }
  return nearest;
}

/// The eighth of a turn, counted around, in which a direction lies.
int eighth_of(float x, float y) {
  // By whether x and y are above zero, and which is larger.
  constexpr int kNumbers[2][2][2] = {{{5, 4}, {6, 7}}, {{2, 3}, {1, 0}}};
  return kNumbers[y > 0.0F ? 1 : 0][x > 0.0F ? 1 : 0][std::abs(x) > std::abs(y) ? 1 : 0];
}

/// Whether bits of eighths leave at most kOpenEighths empty ones beside each other.
bool are_around(unsigned eighths) {
  const unsigned twice = eighths | eighths << 8U;
  int open = 0;
  for (unsigned bit = 0; bit < 16; ++bit) {
    open = (twice >> bit & 1U) != 0 ? 0 : open + 1;
    if (open > kOpenEighths) return false;
  }
  return true;
}

/// Finds the pixels whose points are seen between points of a nearer surface. What is nearer on one
/// side alone hides nothing: the ground is nearer below each of its points.
class HiddenPixels {
 public:
  HiddenPixels(const Image& nearest, double resolution)
      : nearest_(nearest),
        eighths_(nearest.size(), 0),
        reach_(kReach * static_cast<float>(resolution)),
        thickness_(static_cast<float>(resolution) + kNoise) {
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        if (nearest_[at(row, column)] != kEmpty) mark_around(row, column);
      }
    }
  }

  bool operator[](std::size_t pixel) const { return are_around(eighths_[pixel]); }

 private:
  /// Tells all pixels in reach of a point, and behind it, in which direction it lies.
  void mark_around(int row, int column) {
    const float range = nearest_[at(row, column)];
    const float radius = reach_ / (range * kPixel);
    const int rows = static_cast<int>(std::min(radius, static_cast<float>(kRows)));
    for (int i = std::max(-rows, -row); i <= std::min(rows, kRows - 1 - row); ++i) {
      const float elevation = (static_cast<float>(row + i) + 0.5F) * kPixel - 0.5F * kPiFloat;
      const float width = std::cos(elevation);  // of pixels, in that of their height
      const auto up = static_cast<float>(i);
      const float half = std::sqrt(std::max(0.0F, radius * radius - up * up)) / width;
      const int columns = static_cast<int>(std::min(half, 0.5F * kColumns - 1.0F));
      for (int k = -columns; k <= columns; ++k) {
        const std::size_t pixel = at(row + i, column + k);
        if (!(nearest_[pixel] > range + thickness_) || nearest_[pixel] == kEmpty) continue;
        eighths_[pixel] |= 1U << eighth_of(-static_cast<float>(k) * width, -up);
      }
    }
  }

  const Image& nearest_;
  std::vector<unsigned> eighths_;  ///< a bit for each in which a nearer point lies
  float reach_;                    ///< m
  float thickness_;                ///< m
};

/// Sums of the points of a direction.
struct PixelSum {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float intensity = 0.0F;
  float count = 0.0F;

  void add(const Point& point) {
    position += point.position();
    intensity += point.intensity;
    count += 1.0F;
  }
  Point mean() const {
    const Eigen::Vector3f p = position / count;
    return {p.x(), p.y(), p.z(), intensity / count};
  }
};

}  // namespace

PointCloud visible_cloud(const std::vector<PointTilePtr>& tiles, const Pose& T_map_base,
                         const Eigen::Vector3d& p_base_lidar, double resolution) {
  const std::vector<Ray> rays = rays_to(tiles, T_map_base, p_base_lidar.cast<float>());
  const Image nearest = nearest_ranges(rays);
  const HiddenPixels hidden(nearest, resolution);
  const float thickness = static_cast<float>(resolution) + kNoise;
  std::vector<PixelSum> sums(nearest.size());
  for (const Ray& ray : rays) {
    const auto pixel = static_cast<std::size_t>(ray.pixel);
    if (ray.range <= nearest[pixel] + thickness && !ray.is_steep) sums[pixel].add(ray.p_base);
  }
  PointCloud cloud;
  for (std::size_t pixel = 0; pixel < sums.size(); ++pixel) {
    if (sums[pixel].count > 0.0F && !hidden[pixel]) cloud.points.push_back(sums[pixel].mean());
  }
  return cloud;
}

}  // namespace lidar_mapping::map_import
