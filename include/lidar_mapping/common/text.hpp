// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping {

/// A text of any length, formatted like printf() does it.
std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// The parts one after the other, with `separator` between them.
std::string joined(const std::vector<std::string>& parts, const std::string& separator = ", ");

/// The text with the letters A to Z in lower case.
std::string lower_case(std::string text);

}  // namespace lidar_mapping
