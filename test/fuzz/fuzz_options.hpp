// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

namespace lidar_mapping::test {

/// How long a fuzz test runs and where its random numbers begin.
struct FuzzOptions {
  double seconds = 0.0;    ///< of each kind of file; 0: the least number of cases
  std::uint32_t seed = 1;  ///< the same seed gives the same files
};

/// FUZZ_SECONDS and FUZZ_SEED of the environment, where they are set. Without them the same cases
/// are tried on every machine.
inline FuzzOptions fuzz_options() {
  FuzzOptions options;
  if (const char* given = std::getenv("FUZZ_SECONDS")) options.seconds = std::atof(given);
  if (const char* given = std::getenv("FUZZ_SEED")) {
    options.seed = static_cast<std::uint32_t>(std::strtoul(given, nullptr, 10));
  }
  return options;
}

}  // namespace lidar_mapping::test
