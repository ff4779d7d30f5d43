// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::pipeline {

/// The values by their stamp; of several with the same stamp the first.
template <typename Value>
std::map<Stamp, Value> by_stamp(const std::vector<Value>& values) {
  std::map<Stamp, Value> result;
  for (const Value& value : values) result.emplace(value.stamp, value);
  return result;
}

}  // namespace lidar_mapping::pipeline
