// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <vector>

#include "grid_frame.hpp"
#include "ground_raster.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

/// Cells of a block of the grid through which rays of the LiDAR passed between the ground and the
/// height of the vehicle: nothing stood there then.
class FreeSpace {
 public:
  /// All must outlive this.
  FreeSpace(const GridFrame& frame, const GridBlock& block, const GroundRaster& ground,
            const GridOptions& options);

  /// Marks what the rays of all key frames near the block passed. The result depends neither on
  /// their order nor on the number of threads.
  void carve(const GridRays& rays);

  /// By its number in the block.
  bool passed(std::size_t cell) const { return passed_[cell].load(std::memory_order_relaxed) != 0; }

 private:
  /// A straight line, in cells of the block and m of height.
  struct Ray {
    Eigen::Vector3d from;
    Eigen::Vector3d way;
  };
  /// The part of a ray that counts, as shares of its length.
  struct Part {
    double begin;
    double end;
  };

  bool is_near(const Eigen::Vector3d& p_map) const;
  void carve(const PointCloud& cloud, const Pose& T_map_base, const Eigen::Vector3d& p_base_sensor);
  void carve(const Ray& ray);
  Eigen::Vector3d in_block(const Eigen::Vector3d& p_map) const;
  Part part_of(const Ray& ray) const;
  void pass(int column, int row, double z);

  const GridFrame& frame_;
  const GridBlock block_;
  const GroundRaster& ground_;
  const GridOptions options_;
  std::vector<int> ground_columns_;  ///< of the block's columns
  std::vector<int> ground_rows_;     ///< of the block's rows
  std::vector<std::atomic<std::uint8_t>> passed_;
};

}  // namespace lidar_mapping::map
