// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

struct SamplingOptions {
  double resolution = 0.8;  ///< m: one point per cube of this edge
  double min_range = 0.0;   ///< m from the origin of the cloud's frame
  double max_range = 1e4;
  std::size_t stride = 1;  ///< looks at every stride-th point only,
  std::size_t phase = 0;   ///< beginning with this one
  /// Looks at the points in a scattered order, always the same: any of a cube's points is taken
  /// then, not the one in which the sweep came in.
  bool scattered = false;
};

/// Thins a scan out in one pass: the first point that is found in a cube is taken. Cubes are told
/// apart by a hash; a collision merely drops a point. Points that are not finite are left out.
class ScanSampler {
 public:
  /// `table_bits`: log2 of the number of cubes that are told apart.
  explicit ScanSampler(int table_bits);

  /// Indices of the points taken, rising unless scattered; valid until the next call.
  const std::vector<std::uint32_t>& sample(const PointCloud& cloud, const SamplingOptions& options);

 private:
  void next_generation();

  std::uint32_t shift_;
  /// Number of the sampling that last took a point for this hash.
  std::vector<std::uint8_t> last_generation_;
  std::uint8_t generation_ = 0;
  std::vector<std::uint32_t> candidates_;  ///< keeps its size: growing would clear it each time
  std::vector<std::uint32_t> chosen_;
};

/// Coordinates of sampled points in arrays of their own, and their times: seconds after the stamp
/// less `reference`, or zero where the cloud has none.
struct SampledPoints {
  std::vector<float> x, y, z, s;
  std::optional<Eigen::Vector3f> viewpoint;  ///< from which they were seen, where that is known

  std::size_t size() const { return x.size(); }
  void assign(const PointCloud& cloud, const std::vector<std::uint32_t>& indices, double reference);
};

/// Turns all points upwards by `angle` (rad), see ElevationShift.
void raise(SampledPoints& points, double angle);

}  // namespace lidar_mapping::front_end
