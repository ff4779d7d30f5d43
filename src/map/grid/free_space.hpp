// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <vector>

#include "grid/grid_frame.hpp"
#include "grid/ground_raster.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

/// Cells of a block of the grid through which rays of the LiDAR passed between the ground and the
/// height of the vehicle. Nothing stood there when the ray was measured.
class FreeSpace {
 public:
  /// All arguments must outlive this object.
  FreeSpace(const GridFrame& frame, const GridBlock& block, const GroundRaster& ground,
            const GridOptions& options);

  /// Marks the cells that rays of the key frames near the block passed. The result depends neither
  /// on the order of the rays nor on the number of threads.
  void carve(const GridRays& rays);

  /// Whether a ray passed the cell of this index in the block.
  bool passed(std::size_t cell) const { return passed_[cell].load(std::memory_order_relaxed) != 0; }

 private:
  /// A straight line; horizontal coordinates in cells of the block, heights in m.
  struct Ray {
    Eigen::Vector3d start;
    Eigen::Vector3d direction;
  };
  /// The part of a ray that is evaluated, as fractions of its length.
  struct Interval {
    double begin;
    double end;
  };

  bool is_within_reach(const Eigen::Vector3d& p_map) const;
  void carve(const PointCloud& cloud, const Pose& T_map_base, const Eigen::Vector3d& p_base_sensor);
  void carve(const Ray& ray);
  Eigen::Vector3d in_block(const Eigen::Vector3d& p_map) const;
  Interval clipped_interval(const Ray& ray) const;
  void mark_passed(int column, int row, double z);

  const GridFrame& frame_;
  const GridBlock block_;
  const GroundRaster& ground_;
  const GridOptions options_;
  std::vector<int> ground_columns_;  ///< Column of the ground raster for each column of the block.
  std::vector<int> ground_rows_;     ///< Row of the ground raster for each row of the block.
  std::vector<std::atomic<std::uint8_t>> passed_;
};

}  // namespace lidar_mapping::map
