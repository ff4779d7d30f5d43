// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidar_mapping::test {

/// The message of the error of this type that `act` throws; empty if it throws none.
template <typename Expected, typename Act>
std::string error_text(const Act& act) {
  try {
    act();
  } catch (const Expected& error) {
    return error.what();
  }
  return "";
}

}  // namespace lidar_mapping::test
