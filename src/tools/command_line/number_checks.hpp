// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace lidar_mapping::tools {

/// Checks without upper limit, because CLI11's own checks print the largest double as the limit.
inline CLI::Validator at_least(double least, bool itself, const std::string& allowed) {
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0.0;
        const bool fits =
            CLI::detail::lexical_cast(text, value) && (itself ? value >= least : value > least);
        return fits ? std::string() : text + " is not " + allowed;
      },
      "");
}

inline CLI::Validator above_zero() { return at_least(0.0, false, "a number above 0"); }
inline CLI::Validator not_negative() { return at_least(0.0, true, "0 or a number above"); }

}  // namespace lidar_mapping::tools
