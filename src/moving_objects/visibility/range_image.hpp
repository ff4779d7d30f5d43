// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

#include "visibility/visibility_kernels.hpp"

namespace lidar_mapping::moving_objects {

/// Nearest and farthest range in each direction, observed from the sensor; pixels of 0.4 degrees in
/// azimuth and 0.5 in elevation. A location counts as seen through only if all of the 3x3 pixels
/// around it are free, because a beam one pixel aside may hit a pole, and one pixel lower the
/// ground in front.
class RangeImage {
 public:
  /// Builds the image of points in a frame that is parallel to that of the sensor; `sensor` is the
  /// position of the sensor in it.
  RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor);

  int first_row() const { return first_row_; }
  int rows() const { return rows_; }

  /// Counts what the sensor observed at the targets; `ambiguous` has room for `count` numbers.
  void classify(const ProjectedPixels& targets, std::size_t count, const VisibilityCounts& counts,
                int* ambiguous) const;

 private:
  static std::size_t pixel_at(int column, int row) {
    return static_cast<std::size_t>(row) * kRangeImageColumns + static_cast<std::size_t>(column);
  }
  void prefetch_window(int pixel) const;
  int is_hit_around(int pixel, int nearest, int farthest) const;

  int first_row_ = 0;
  int rows_ = 0;
  /// Pixels row by row. Each row begins with a copy of its last column and ends with one of its
  /// first column. There is one more row above and below, whose pixels are unobserved.
  std::vector<RangeInterval> pixels_;
  /// Union of the 3x3 pixels around each pixel, unobserved if that pixel is empty; then an
  /// unobserved one for everything outside.
  std::vector<RangeInterval> windows_;
};

}  // namespace lidar_mapping::moving_objects
