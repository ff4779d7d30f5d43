// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

struct SamplingOptions {
  double resolution = 0.8;  ///< m: one point per cube of this edge
  double min_range = 0.0;   ///< m from the origin of the cloud's frame
  double max_range = 1e4;
  std::size_t stride = 1;  ///< uses only every stride-th point
  std::size_t phase = 0;   ///< number of the first point
  /// Visits the points in a scattered order, which is always the same. Then any point of a cube may
  /// be chosen, and not always the one at the side from which the sweep comes.
  bool scattered = false;
};

/// Thins out a scan in one pass: the first point found in a cube is kept. Cubes are distinguished
/// by a hash; a collision only drops a point. Points with non-finite coordinates are left out.
class ScanSampler {
 public:
  /// `table_bits`: log2 of the number of cubes that can be distinguished.
  explicit ScanSampler(int table_bits);

  /// Indices of the selected points, in ascending order unless scattered; valid until the next
  /// call.
  const std::vector<std::uint32_t>& sample(const PointCloud& cloud, const SamplingOptions& options);

 private:
  void next_generation();

  std::uint32_t shift_;
  /// Number of the sampling that last selected a point with this hash.
  std::vector<std::uint8_t> last_generation_;
  std::uint8_t generation_ = 0;
  /// keeps its size, because resizing would clear it each time
  std::vector<std::uint32_t> candidates_;
  std::vector<std::uint32_t> chosen_;
};

/// For each point 1 if it is marked, else 0.
using PointMarks = std::vector<std::uint8_t>;

/// Coordinates of sampled points in separate arrays, and their times: seconds after the stamp minus
/// `reference`, or zero if the cloud has no times.
struct SampledPoints {
  std::vector<float> x, y, z, s;
  std::optional<Eigen::Vector3f> viewpoint;  ///< from which the points were measured, if known

  std::size_t size() const { return x.size(); }
  void assign(const PointCloud& cloud, const std::vector<std::uint32_t>& indices, double reference);
  void push_back(const Eigen::Vector3f& p, float time);
  Eigen::Vector3f position(std::size_t i) const { return {x[i], y[i], z[i]}; }
  /// Removes the points that are marked; the others keep their order.
  void remove(const PointMarks& marks);
};

/// Rotates all points upwards by `angle` (rad), see ElevationShift.
void rotate_upwards(SampledPoints& points, double angle);

}  // namespace lidar_mapping::front_end
