// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

namespace lidar_mapping {

/// The number whose bytes begin at an address of any alignment, in the processor's order of bytes.
template <typename Number>
Number number_at(const std::uint8_t* address) {
  Number number;
  std::memcpy(&number, address, sizeof number);
  return number;
}

}  // namespace lidar_mapping
