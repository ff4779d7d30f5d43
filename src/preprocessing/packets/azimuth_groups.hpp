// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace lidar_mapping::preprocessing {

/// Counts of azimuth in a turn: 0.01 degrees each, by the user's manual of Velodyne and of Hesai.
constexpr unsigned kTurn = 36000;

/// The blocks of a packet that were measured at the same azimuth: of several banks of lasers, and
/// all returns where a laser has more than one.
struct AzimuthGroup {
  std::size_t begin = 0;  ///< first block
  std::size_t end = 0;    ///< after the last block
  unsigned azimuth = 0;   ///< counts
  double step = 0.0;      ///< counts to the next group; the last group has that of the one before
};

/// The groups of a packet with these azimuths of its `count` blocks, counts.
std::vector<AzimuthGroup> azimuth_groups(const unsigned* azimuths, std::size_t count);

}  // namespace lidar_mapping::preprocessing
