// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::ros_border {

/// Positions by GNSS that came after the newest key frame. The position of a scan comes before its
/// key frame, and only the key frame says which run it belongs to: what came before the first key
/// frame of a run is handed to the run when that begins.
class UnclaimedPositions {
 public:
  /// Largest number that is kept; the oldest is dropped. Chosen: over three minutes at 10 Hz,
  /// longer than any front end needs for its first key frame; bounds the memory.
  static constexpr std::size_t kMost = 2000;

  /// Keeps a position.
  void add(const GnssPosition& position) {
    positions_.push_back(position);
    if (positions_.size() > kMost) positions_.pop_front();
  }
  /// Drops the positions up to the stamp of a key frame: no key frame that follows has their
  /// stamps.
  void drop_until(Stamp stamp) {
    const auto is_claimed = [stamp](const GnssPosition& kept) { return kept.stamp <= stamp; };
    positions_.erase(std::remove_if(positions_.begin(), positions_.end(), is_claimed),
                     positions_.end());
  }

  /// In the order in which they came.
  const std::deque<GnssPosition>& positions() const { return positions_; }

 private:
  std::deque<GnssPosition> positions_;
};

}  // namespace lidar_mapping::ros_border
