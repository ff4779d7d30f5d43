// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace lidar_mapping::test {

/// Succeeds if a text has these words; a failed assertion shows both. For use as
/// `EXPECT_TRUE(holds(text, "words"))`, or with EXPECT_FALSE.
inline testing::AssertionResult holds(const std::string& text, const std::string& words) {
  constexpr std::size_t kShown = 20'000;  // characters; chosen: all but whole pages of HTML
  const bool is_there = text.find(words) != std::string::npos;
  return testing::AssertionResult(is_there)
         << "'" << words << (is_there ? "' is in:\n" : "' is not in:\n") << text.substr(0, kShown);
}

}  // namespace lidar_mapping::test
