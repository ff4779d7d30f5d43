// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The distance (m) at which the closer ones of the points have their nearest neighbour: in clouds
/// that were thinned out by voxels, about the edge of these. 0 without points.
double point_spacing(const PointCloud& cloud);

/// Counts points in cubes whose edge grows with the distance from the sensor, their origin.
class RangeGrid {
 public:
  RangeGrid();

  /// The edge of cubes is this share of the range, at least 0.015, or this length where that is
  /// more.
  void set_edge(double fraction_of_range, double min_edge);
  /// Forgets all points and makes room for so many.
  void clear(std::size_t points);
  void insert(const Point* points, std::size_t count);
  /// True if less than two other points lie in the eight cubes nearest to this one, which was
  /// inserted. What has no range of use is never isolated.
  bool is_isolated(const Point& point) const;

 private:
  /// Where a point lies in the grid of its range: level 0 for none.
  struct Place {
    std::uint32_t level = 0;
    float x = 0.0F, y = 0.0F, z = 0.0F;  ///< in edges of the level's cubes, above zero
  };

  Place place_of(const Point& point) const;
  std::size_t find(std::uint32_t key) const;
  std::uint32_t count_at(std::uint32_t key) const;

  static constexpr std::size_t kLevels = 32;
  std::array<float, kLevels> inverse_edge_{};
  /// Key of a cube times 4 and how many points it holds, at most three; 0 where there is none.
  std::vector<std::uint32_t> table_;
  std::uint32_t shift_ = 31;
};

/// Leaves points out that lie on no surface: drops of rain, dust, echoes of other sensors. A
/// sampling with one point per cube would make them count for far more than their share. Where they
/// are few nothing is left out, as leaves and the edges of things have some that look so.
class SurfaceSupport {
 public:
  SurfaceSupport();

  /// The scan as it is, or where many points are isolated, without these. Valid until the next
  /// call, and as long as `scan` is.
  const Scan& without_isolated_points(const Scan& scan);
  /// Running mean of the share of isolated points.
  double isolated_fraction() const { return mean_isolated_fraction_; }

 private:
  /// Share of isolated points in a part of the scan, block by block.
  double isolated_fraction_in_blocks(const PointCloud& cloud);
  std::size_t count_isolated(const PointCloud& cloud, std::size_t begin, std::size_t end) const;
  void set_cube_edge(const PointCloud& cloud);
  /// Makes filtered_ the scan without its isolated points, and returns their share.
  double filter(const Scan& scan);
  void copy_supported(const PointCloud& cloud, std::size_t begin, std::size_t end);
  void learn(double fraction);

  RangeGrid grid_;
  double spacing_ = 0.0;  ///< m; see point_spacing()
  bool spacing_known_ = false;
  std::size_t next_block_ = 0;
  double mean_isolated_fraction_ = -1.0;  ///< below zero before the first scan
  Scan filtered_;
};

}  // namespace lidar_mapping::front_end
