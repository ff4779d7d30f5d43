// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "command_line/child_program.hpp"
#include "error_text.hpp"
#include "holds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;

/// A script in a folder whose name no shell reads as one word.
class ChildProgram : public testing::Test {
 protected:
  ChildProgram() {
    fs::create_directory(script_.parent_path());
    std::ofstream(script_) << "#!/bin/sh\nprintf '%s\\n' \"$@\" > \"$1\"\nexit $2\n";
    fs::permissions(script_, fs::perms::owner_all);
  }

  const test::TemporaryFolder folder_;
  const fs::path script_ = folder_.path() / "it's a 'folder' $HOME" / "tell words";
};

TEST_F(ChildProgram, GetsEachWordAsItIs) {
  const std::string file = folder_.path() / "o'clock \"now\".txt";
  run_program(script_, {file, "0", "; touch x", "$(touch y)", "", "'"});
  std::ifstream stream(file);
  std::vector<std::string> words;
  for (std::string word; std::getline(stream, word);) words.push_back(word);
  EXPECT_EQ(words, (std::vector<std::string>{file, "0", "; touch x", "$(touch y)", "", "'"}));
}

TEST_F(ChildProgram, IsNamedWhenItFails) {
  const std::string problem = test::error_text<FileError>([this] {
    run_program(script_, {folder_.path() / "words", "7"});
  });
  EXPECT_TRUE(test::holds(problem, "ended with status 7"));
  EXPECT_TRUE(test::holds(problem, "tell words"));
  EXPECT_THROW(run_program(folder_.path() / "missing", {}), FileError);
}

TEST(CommandLine, IsWhatOneWouldType) {
  EXPECT_EQ(command_line({"map_bag", "a b.bag", "-o", "it's", ""}),
            "map_bag 'a b.bag' -o 'it'\\''s' ''");
}

}  // namespace
}  // namespace lidar_mapping::tools
