// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping {

/// Hash of the cloud's size and of the positions of a sample of its points, rounded to 0.1 mm. No
/// sensor measures all ranges exactly equal twice, so a cloud with the fingerprint of the previous
/// one is the same measurement again. Empty if so few of these points have a return that they may
/// be equal by chance.
std::optional<std::uint64_t> cloud_fingerprint(const PointCloud& cloud);

/// The same of `count` points in memory: x y z (m) as adjacent floats from `first` on, and `step`
/// bytes from one point to the next.
std::optional<std::uint64_t> cloud_fingerprint(const unsigned char* first, std::size_t step,
                                               std::size_t count);

}  // namespace lidar_mapping
