// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/coarse_key.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

// Chosen: harmonics of a descriptor of norm 1 are mostly below 1, so they take half of the steps of
// a byte.
constexpr float kStepSize = 1.0F / 128.0F;
// Steps, the largest number of a byte, by its format; a larger value adds to the rounding error.
constexpr float kMaxStep = 255.0F;
// Relative rounding error of a distance in single precision. Chosen: far above that of some hundred
// additions (6e-8 each).
constexpr float kRounding = 1e-4F;

}  // namespace

CoarseKey::CoarseKey(const SpectrumDescriptor::Key& key) : steps_{}, error_(0.0F) {
  float squared_error = 0.0F;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const float value = key[static_cast<Eigen::Index>(i)];
    const float rounded = std::min(kMaxStep, std::floor(value / kStepSize + 0.5F));
    steps_[i] = static_cast<std::uint8_t>(rounded);
    squared_error += std::pow(value - rounded * kStepSize, 2.0F);
  }
  error_ = std::sqrt(squared_error);
}

CoarseKey::Bounds CoarseKey::distance_to(const CoarseKey& other) const {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const auto difference = static_cast<std::int16_t>(steps_[i] - other.steps_[i]);
    sum += difference * difference;
  }
  const float distance = kStepSize * std::sqrt(static_cast<float>(sum));
  const float error = (1.0F + kRounding) * (error_ + other.error_) + kRounding * distance;
  return {distance - error, distance + error};
}

}  // namespace lidar_mapping::loop_closing
