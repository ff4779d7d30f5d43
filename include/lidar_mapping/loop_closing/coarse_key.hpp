// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

namespace lidar_mapping::loop_closing {

/// The key of a descriptor, rounded to a quarter of its memory, with the rounding error.
class CoarseKey {
 public:
  /// Rounds a key.
  explicit CoarseKey(const SpectrumDescriptor::Key& key);

  /// Bounds of the Euclidean distance between two keys, without unit.
  struct Bounds {
    float lower = 0.0F;  ///< the distance is at least this; may be negative
    float upper = 0.0F;  ///< the distance is at most this
  };
  /// Bounds of the distance between the two keys before rounding.
  Bounds distance_to(const CoarseKey& other) const;

 private:
  std::array<std::uint8_t, SpectrumDescriptor::Key::SizeAtCompileTime> steps_;
  float error_;  ///< distance from the key before rounding
};

}  // namespace lidar_mapping::loop_closing
