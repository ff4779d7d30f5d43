// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// Iterator to the first of values with increasing stamps that is not before this stamp; the end if
/// all are.
template <typename Values>
auto first_not_before(Values& values, Stamp stamp) {
  return std::lower_bound(values.begin(), values.end(), stamp,
                          [](const auto& value, Stamp wanted) { return value.stamp < wanted; });
}

/// Iterator to the one with this index among values with increasing indices of key frames; the end
/// if there is none.
template <typename Values>
auto find_index(Values& values, KeyFrameIndex index) {
  const auto found = std::lower_bound(
      values.begin(), values.end(), index,
      [](const auto& value, KeyFrameIndex wanted) { return value.index < wanted; });
  return found != values.end() && found->index == index ? found : values.end();
}

}  // namespace lidar_mapping
