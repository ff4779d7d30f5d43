// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// Hash of the cloud's size and of the positions of a sample of its points, rounded to 0.1 mm.
std::uint64_t cloud_fingerprint(const PointCloud& cloud);

/// Detects a driver that delivers the same scan again under a new stamp: no sensor measures all
/// ranges exactly equal twice.
class RepeatedScans {
 public:
  /// True if the points are those of the previous cloud. Clouds with very few points never count as
  /// repeated.
  bool is_repeated(const PointCloud& cloud);
  void reset() { last_.reset(); }

 private:
  std::optional<std::uint64_t> last_;
};

}  // namespace lidar_mapping::front_end
