// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// A text of any length, formatted like printf() does it.
std::string formatted(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// The parts one after the other, with `separator` between them.
std::string joined(const std::vector<std::string>& parts, const std::string& separator = ", ");

/// A number of things: "1 key frame", otherwise "3 key frames", with an s behind the noun.
std::string counted(std::size_t count, const std::string& noun);

/// Whether a text is one of several.
bool contains(const std::vector<std::string>& texts, const std::string& text);

/// The text with the letters A to Z in lower case.
std::string lower_case(std::string text);

/// Whether `a` comes before `b` as a person orders files: digits in a row are compared as one
/// number, so scan9 comes before scan10, and behind a decimal point as its decimals.
bool in_order_of_numbers(const std::string& a, const std::string& b);

/// The text between two `mark`s, with each of those in it doubled, as CSV (") and YAML (') have it.
std::string quoted(const std::string& text, char mark);

/// The seconds of a stamp with all nine decimals, so that it comes back from a file exactly.
std::string seconds_text(Stamp stamp);

}  // namespace lidar_mapping
