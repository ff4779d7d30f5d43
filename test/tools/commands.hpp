// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "holds.hpp"
#include "program.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// The status with which a command ended. A failed assertion shows what it had said, too.
struct Ending {
  int status = 0;
  std::string said;

  bool operator==(int expected) const { return status == expected; }
  bool operator<=(int most) const { return status <= most; }
};
inline std::ostream& operator<<(std::ostream& out, const Ending& ending) {
  return out << ending.status << " after saying\n" << ending.said;
}

/// Runs commands of this package. Their files lie in one folder for all tests of a program, or in
/// one of the test.
class Commands : public testing::Test {
 protected:
  static const std::filesystem::path& root() {
    static const TemporaryFolder folder;
    return folder.path();
  }
  static Ending run(const std::string& program, const Words& words) {
    const int status = Program(program, words, root() / "log").wait();
    return {status, said()};
  }
  /// What the last one has said.
  static std::string said() { return content_of(root() / "log"); }
  static testing::AssertionResult has_said(const std::string& words) {
    return holds(said(), words);
  }

  static Words joined(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  const TemporaryFolder folder_;  ///< of the test
};

}  // namespace lidar_mapping::test
