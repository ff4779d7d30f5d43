// SPDX-License-Identifier: BSD-3-Clause
#include "packets/azimuth_groups.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// Largest turn from block to block, counts. Chosen: no sensor turns so far, even at 20 Hz.
constexpr unsigned kLargestStep = 500;

}  // namespace

std::vector<AzimuthGroup> azimuth_groups(const unsigned* azimuths, std::size_t count) {
  std::vector<AzimuthGroup> groups;
  for (std::size_t b = 0; b < count; ++b) {
    if (groups.empty() || groups.back().azimuth != azimuths[b]) {
      groups.push_back({b, b, azimuths[b], 0.0});
    }
    groups.back().end = b + 1;
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool is_last = g + 1 == groups.size();
    const unsigned step =
        is_last ? 0U : (groups[g + 1].azimuth + kTurn - groups[g].azimuth) % kTurn;
    if (step > 0U && step <= kLargestStep) groups[g].step = step;
    if (groups[g].step == 0.0 && g > 0) groups[g].step = groups[g - 1].step;
  }
  return groups;
}

}  // namespace lidar_mapping::preprocessing
