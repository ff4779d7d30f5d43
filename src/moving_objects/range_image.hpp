// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

#include "visibility_kernels.hpp"

namespace lidar_mapping::moving_objects {

/// Nearest and farthest range in each direction, seen from the sensor; 0.4 degrees in azimuth, 0.5
/// in elevation. A place counts as seen through only if all of the 3x3 directions around it are
/// free: a beam one step aside may touch a pole, one step lower the ground in front.
class RangeImage {
 public:
  /// Points in a frame that is parallel to the sensor's, and where the sensor is in it.
  RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor);

  int first_row() const { return first_row_; }
  int rows() const { return rows_; }

  /// Counts what the sensor saw of some places; `unclear` has room for as many numbers.
  void look(const ProjectedPixels& targets, std::size_t count, const Counts& counts,
            int* unclear) const;

 private:
  static std::size_t pixel_at(int column, int row) {
    return static_cast<std::size_t>(row) * kRangeImageColumns + static_cast<std::size_t>(column);
  }
  void fetch_around(int pixel) const;
  int is_hit_around(int pixel, int nearest, int farthest) const;

  int first_row_ = 0;
  int rows_ = 0;
  /// Row by row: first the last column again, behind the last column the first. A row in which
  /// nothing is within any range is above and one is below.
  std::vector<Seen> pixels_;
  /// 3x3 around each pixel, hidden where that is empty; then a hidden one for what is outside.
  std::vector<Seen> windows_;
};

}  // namespace lidar_mapping::moving_objects
