// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

namespace lidar_mapping::loop_closing {

/// The key of a descriptor in a quarter of its memory, with how far it is from the true one.
class CoarseKey {
 public:
  explicit CoarseKey(const SpectrumDescriptor::Key& key);

  /// Limits of the distance between two keys.
  struct Bounds {
    float lower = 0.0F;
    float upper = 0.0F;
  };
  Bounds distance_to(const CoarseKey& other) const;

 private:
  std::array<std::uint8_t, SpectrumDescriptor::Key::SizeAtCompileTime> steps_;
  float error_;  ///< distance from the true key
};

}  // namespace lidar_mapping::loop_closing
