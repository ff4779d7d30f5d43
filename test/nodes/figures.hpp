// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <regex>
#include <string>

#include <diagnostic_msgs/DiagnosticArray.h>

#include "listener.hpp"

namespace lidar_mapping::test {

using Diagnostics = Listener<diagnostic_msgs::DiagnosticArray>;

/// A node has reported, or reports within the usual patience, a figure of this name whose whole
/// value fits a regular expression.
inline bool reports(const Diagnostics& diagnostics, const std::string& key,
                    const std::string& pattern) {
  const std::regex wanted(pattern);
  const auto fits = [&](const auto& figure) {
    return figure.key == key && std::regex_match(figure.value, wanted);
  };
  return wait_until([&] {
    return std::any_of(diagnostics.messages.begin(), diagnostics.messages.end(),
                       [&](const auto& message) {
                         const auto& figures = message.status.at(0).values;
                         return std::any_of(figures.begin(), figures.end(), fits);
                       });
  });
}

}  // namespace lidar_mapping::test
