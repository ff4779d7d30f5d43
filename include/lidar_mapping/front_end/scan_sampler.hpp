#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// Some points of a scan, coordinates in arrays of their own; times are zero where there are none.
struct SampledPoints {
  std::vector<float> x, y, z, s;

  std::size_t size() const { return x.size(); }
  void clear();
  void push(const Point& point, float time);
};

struct SamplingOptions {
  double resolution = 0.8;  ///< m: one point per cube of this edge
  double min_range = 1.0;   ///< m from the origin of the cloud's frame
  double max_range = 100.0;
  std::size_t stride = 1;  ///< looks at every stride-th point only,
  std::size_t phase = 0;   ///< beginning with this one
};

/// Thins a scan out in one pass: the first point that falls into a cube is taken. Cubes are told
/// apart by a hash; a collision merely drops a point. Not finite points are left out.
class ScanSampler {
 public:
  /// `table_bits`: log2 of the number of cubes that are told apart.
  explicit ScanSampler(int table_bits);

  void sample(const PointCloud& cloud, const SamplingOptions& options, SampledPoints& result);

 private:
  void next_generation();

  std::uint32_t shift_;
  /// Number of the sampling that last took a point for this hash.
  std::vector<std::uint8_t> taken_;
  std::uint8_t generation_ = 0;
};

}  // namespace lidar_mapping::front_end
