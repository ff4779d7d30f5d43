// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// The lower quartile of the distances (m) between points and their nearest neighbours. In clouds
/// that were thinned out by voxels, this is about the voxel size. 0 without points.
double point_spacing(const PointCloud& cloud);

/// Counts points in cubes whose edge length grows with the distance from the sensor, which is the
/// origin.
class RangeGrid {
 public:
  RangeGrid();

  /// The edge length of the cubes is this fraction of the range, but at least 0.015 of the range,
  /// and at least `min_edge` (m).
  void set_edge(double fraction_of_range, double min_edge);
  /// Removes all points and allocates space for this number of points.
  void clear(std::size_t points);
  void insert(const Point* points, std::size_t count);
  /// True if fewer than two other points lie in the eight cubes nearest to this point, which must
  /// have been inserted. A point whose range is not usable is never isolated.
  bool is_isolated(const Point& point) const;

 private:
  /// Position of a point in the grid of its range; level 0 for none.
  struct GridPosition {
    std::uint32_t level = 0;
    float x = 0.0F, y = 0.0F, z = 0.0F;  ///< in edge lengths of the level's cubes, positive
  };

  GridPosition position_of(const Point& point) const;
  std::size_t find(std::uint32_t key) const;
  std::uint32_t count_at(std::uint32_t key) const;

  /// Levels of the range, each sqrt(2) times the last one. Chosen: twenty reach 512 m.
  static constexpr std::size_t kMaxLevels = 20;
  std::array<float, kMaxLevels + 1> inverse_edge_{};  ///< by level; level 0 is not used
  /// Key of a cube times 4, plus its number of points, at most three; 0 for an empty entry.
  std::vector<std::uint32_t> table_;
  std::uint32_t shift_ = 31;
};

/// Removes points that do not lie on a surface: raindrops, dust, echoes of other sensors. With a
/// sampling of one point per cube, they would have far too much weight. If they are few, nothing is
/// removed, because some points on leaves and edges look like them.
class IsolatedPointFilter {
 public:
  /// The scan itself or, if many points are isolated, a copy without them. Valid until the next
  /// call, and as long as `scan` is valid.
  const Scan& without_isolated_points(const Scan& scan);
  /// Running mean of the fraction of isolated points; for tests.
  double isolated_fraction() const { return mean_isolated_fraction_; }

 private:
  /// Fraction of isolated points in a part of the scan, block by block.
  double isolated_fraction_in_blocks(const PointCloud& cloud);
  std::size_t count_isolated(const PointCloud& cloud, std::size_t begin, std::size_t end) const;
  void set_cube_edge(const PointCloud& cloud);
  /// Sets filtered_ to the scan without its isolated points, and returns their fraction.
  double filter(const Scan& scan);
  void copy_supported(const PointCloud& cloud, std::size_t begin, std::size_t end);
  void learn(double fraction);

  RangeGrid grid_;
  double spacing_ = 0.0;  ///< m; see point_spacing()
  bool spacing_known_ = false;
  std::size_t next_block_ = 0;
  double mean_isolated_fraction_ = -1.0;  ///< negative before the first scan
  Scan filtered_;
};

}  // namespace lidar_mapping::front_end
