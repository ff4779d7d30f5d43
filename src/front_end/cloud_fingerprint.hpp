// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::front_end {

/// Hash of a cloud's size and of the places of a sample of its points, to a tenth of a millimetre.
std::uint64_t cloud_fingerprint(const PointCloud& cloud);

/// Notices a driver that delivers the same scan again, under new stamps: no sensor measures all
/// ranges twice alike.
class RepeatedScans {
 public:
  /// True if the points are those of the cloud before. Clouds that are nearly empty never are.
  bool is_repeated(const PointCloud& cloud);
  void reset() { last_.reset(); }

 private:
  std::optional<std::uint64_t> last_;
};

}  // namespace lidar_mapping::front_end
