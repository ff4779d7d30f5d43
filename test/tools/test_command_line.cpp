// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "command_line/number_checks.hpp"
#include "command_line/overwriting.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/progress_bar.hpp"
#include "command_line/run_command.hpp"
#include "error_text.hpp"
#include "holds.hpp"
#include "parameters/config_path.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

using test::error_text;
using test::holds;

/// What a command that was called as /opt/bin/measure with these words writes and ends with.
struct Ended {
  int status = 0;
  std::string out, err;
};

template <typename Run>
Ended ended(std::vector<std::string> words, const Run& run, int failed = 1) {
  CLI::App app("Measures");
  double length = 0.0;
  app.add_option("--length", length, "m")->check(above_zero());
  std::string program = "/opt/bin/measure";
  std::vector<char*> argv = {program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  Ended result;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  result.status = run_command(
      app, static_cast<int>(argv.size()), argv.data(), [&] { return run(length); }, failed);
  result.out = testing::internal::GetCapturedStdout();
  result.err = testing::internal::GetCapturedStderr();
  return result;
}

TEST(RunCommand, GivesTheExitStatus) {
  double read = 0.0;
  EXPECT_EQ(ended({"--length", "2.5"}, [&](double length) { read = length; }).status, 0);
  EXPECT_EQ(read, 2.5);
  EXPECT_EQ(ended({}, [](double) { return 4; }).status, 4);
}

TEST(RunCommand, NamesTheCommandBeforeItsError) {
  const auto fail = [](double) { throw std::runtime_error("the folder is not there"); };
  const Ended result = ended({}, fail);
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.err, "measure: the folder is not there\n");
  EXPECT_EQ(ended({}, fail, 2).status, 2);
}

TEST(RunCommand, DoesNothingWithAWrongWordOrForHelp) {
  bool has_run = false;
  const auto run = [&](double) { has_run = true; };
  const Ended wrong = ended({"--length", "-1"}, run);
  EXPECT_NE(wrong.status, 0);
  EXPECT_NE(wrong.err.find("--length: -1 is not a number above 0"), std::string::npos) << wrong.err;
  const Ended help = ended({"--help"}, run);
  EXPECT_EQ(help.status, 0);
  EXPECT_NE(help.out.find("Measures"), std::string::npos);
  EXPECT_FALSE(has_run);
}

TEST(NumberChecks, RefuseWhatIsBelowTheLimit) {
  const auto refused = [](const CLI::Validator& check, std::string text) {
    return !check(text).empty();
  };
  EXPECT_TRUE(refused(above_zero(), "0"));
  EXPECT_FALSE(refused(above_zero(), "1e-9"));
  EXPECT_FALSE(refused(not_negative(), "0"));
  EXPECT_TRUE(refused(not_negative(), "-1e-9"));
  EXPECT_FALSE(refused(above_zero(), "1e300")) << "there is no upper limit";
  for (const char* none : {"", "many", "nan"}) {
    EXPECT_TRUE(refused(above_zero(), none)) << none;
    EXPECT_TRUE(refused(not_negative(), none)) << none;
  }
}

class CommandFiles : public testing::Test {
 protected:
  std::string file(const std::string& name) {
    std::ofstream(folder_.path() / name) << "there\n";
    return folder_.path() / name;
  }
  test::TemporaryFolder folder_;
};

TEST_F(CommandFiles, AreOverwrittenOnlyOnRequest) {
  const std::string there = file("drive.bag"), absent = folder_.path() / "other.bag";
  EXPECT_NO_THROW(check_overwriting({absent, ""}, false));
  EXPECT_NO_THROW(check_overwriting({absent, there}, true));
  EXPECT_EQ(error_text<FileError>([&] {
              check_overwriting({absent, there}, false);
            }),
            there + " exists; name another file, or give --force to overwrite it");
}

TEST_F(CommandFiles, OfAStageAreFoundInAFolderOrByTheirName) {
  const std::string back_end = file("back_end.yaml"), other = file("mine.yaml");
  EXPECT_EQ(stage_file("", "back_end"), "");
  EXPECT_EQ(stage_file(folder_.path(), "back_end"), back_end);
  EXPECT_EQ(stage_file(folder_.path(), "map"), "") << "not every stage has one";
  EXPECT_EQ(stage_file(back_end, "back_end"), back_end);
  EXPECT_EQ(stage_file(back_end, "map"), "") << "it is of another stage";
  EXPECT_TRUE(holds(error_text<FileError>([&] { stage_file(folder_.path() / "absent", "map"); }),
                    "no folder or"));
  EXPECT_EQ(only_stage_file(other, "back_end"), other) << "the only stage's may have any name";
  EXPECT_EQ(only_stage_file("", "back_end"), "");
  EXPECT_EQ(only_stage_file(folder_.path(), "back_end"), back_end);
  EXPECT_TRUE(holds(error_text<FileError>([&] { only_stage_file(folder_.path(), "map"); }),
                    "there is no map.yaml"));
}

TEST(ProcessMemory, GrowsWithWhatIsTouched) {
  constexpr std::size_t kBytes = 64U << 20U;
  const std::size_t before = resident_bytes();
  const std::vector<char> block(kBytes, 'x');
  EXPECT_GT(resident_bytes(), before + kBytes / 2);
  EXPECT_GE(peak_bytes(), before + kBytes / 2);
  EXPECT_NEAR(peak_mebibytes(), static_cast<double>(peak_bytes()) / 1048576.0, 1.0);
  EXPECT_EQ(block.back(), 'x');
}

/// Without a terminal, as under a test.
TEST(ProgressBar, HasALineForEveryTenth) {
  testing::internal::CaptureStderr();
  ProgressBar bar("writing scans", 40);
  for (std::size_t i = 1; i <= 40; ++i) bar.show(i);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10) << text;
  EXPECT_EQ(text.find("writing scans: 10 % (4 of 40)\n"), 0U) << text;
  EXPECT_NE(text.find("writing scans: 100 % (40 of 40)\n"), std::string::npos);
  testing::internal::CaptureStderr();
  ProgressBar("writing nothing", 0).show(0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "writing nothing: 100 % (0 of 0)\n");
}

}  // namespace
}  // namespace lidar_mapping::tools
