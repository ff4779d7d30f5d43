// SPDX-License-Identifier: BSD-3-Clause
// Files that appear whole or not at all, files without a name, and errors that name a file.

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/list_file.hpp"
#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/common/pcd_header.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

namespace fs = std::filesystem;
using test::content_of;

/// The message of the FileError that `act` throws; empty if it throws none.
template <typename Act>
std::string file_error_of(const Act& act) {
  return test::error_text<FileError>(act);
}

class Files : public testing::Test {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      result.push_back(entry.path().filename().string());
    }
    return result;
  }
  test::TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "map.txt";
};

using AtomicFile = Files;

TEST_F(AtomicFile, AppearsWithItsWholeContentAndLeavesNothingBeside) {
  write_atomically(path_, [&](const fs::path& temporary) {
    EXPECT_EQ(temporary.parent_path(), path_.parent_path()) << "renaming needs one file system";
    EXPECT_EQ(temporary.filename().string().front(), '.') << "hidden meanwhile";
    std::ofstream(temporary) << "first";
    EXPECT_FALSE(fs::exists(path_));
  });
  EXPECT_EQ(content_of(path_), "first");
  EXPECT_EQ(names(), std::vector<std::string>{"map.txt"});
}

TEST_F(AtomicFile, ReplacesTheOldOneOnlyWhenItIsComplete) {
  write_text_atomically(path_, "old");
  write_atomically(path_, [&](const fs::path& temporary) {
    std::ofstream(temporary) << "new";
    EXPECT_EQ(content_of(path_), "old");
  });
  EXPECT_EQ(content_of(path_), "new");
}

TEST_F(AtomicFile, LeavesTheOldOneIfWritingFails) {
  write_text_atomically(path_, "old");
  const auto write_half = [&](const fs::path& temporary) {
    std::ofstream(temporary) << "half";
    throw std::runtime_error("the disk is full");
  };
  const std::string message = file_error_of([&] { write_atomically(path_, write_half); });
  EXPECT_NE(message.find(path_.string()), std::string::npos) << message;
  EXPECT_NE(message.find("the disk is full"), std::string::npos) << message;
  EXPECT_EQ(content_of(path_), "old");
  EXPECT_EQ(names(), std::vector<std::string>{"map.txt"}) << "the half one is gone";
}

TEST_F(AtomicFile, PassesOnAFileErrorAsItIs) {
  const auto fail = [](const fs::path& /*temporary*/) {
    throw FileError("another file is damaged");
  };
  EXPECT_EQ(file_error_of([&] { write_atomically(path_, fail); }), "another file is damaged");
  EXPECT_TRUE(names().empty());
}

TEST_F(AtomicFile, PassesOnWhatIsWrongWithTheContent) {
  const auto fail = [](const fs::path& temporary) {
    std::ofstream(temporary) << "half";
    throw InputError("the map has no points");
  };
  EXPECT_THROW(write_atomically(path_, fail), InputError) << "free space would not help";
  EXPECT_TRUE(names().empty());
}

TEST_F(AtomicFile, MakesMissingFolders) {
  write_text_atomically(folder_.path() / "a" / "b" / "map.txt", "there");
  EXPECT_EQ(content_of(folder_.path() / "a" / "b" / "map.txt"), "there");
}

TEST_F(AtomicFile, KeepsTheBytesOfAText) {
  const std::string text("a\r\nb\0c", 6);
  write_text_atomically(path_, text);
  EXPECT_EQ(content_of(path_), text);
}

TEST_F(AtomicFile, HasWhatIsPutIntoItsStream) {
  const auto write = [](std::ostream& file) { file << "map " << 7; };
  write_stream_atomically(path_, write);
  EXPECT_EQ(content_of(path_), "map 7");
  EXPECT_EQ(file_error_of([&] { write_stream_atomically("/dev/full", write); }),
            "cannot write /dev/full; check the free space and the permissions");
}

TEST_F(AtomicFile, SaysWhereItCannotWrite) {
  write_text_atomically(path_, "a file, no folder");
  const std::string message = file_error_of([&] { write_text_atomically(path_ / "x", "text"); });
  EXPECT_NE(message.find("cannot write " + (path_ / "x").string()), std::string::npos) << message;
}

/// As /dev/stdout, which a file must not replace.
TEST_F(AtomicFile, WritesIntoAPipeAndLeavesItThere) {
  ASSERT_EQ(mkfifo(path_.c_str(), S_IRUSR | S_IWUSR), 0);
  const int pipe = open(path_.c_str(), O_RDWR);  // so that the writer does not wait for a reader
  ASSERT_GE(pipe, 0);
  write_text_atomically(path_, "figures");
  std::array<char, 16> bytes{};
  ASSERT_TRUE(fs::is_fifo(path_));
  EXPECT_EQ(read(pipe, bytes.data(), bytes.size()), 7);
  EXPECT_STREQ(bytes.data(), "figures");
  close(pipe);
}

using InputFile = Files;

TEST_F(InputFile, IsOpenedForReading) {
  write_text_atomically(path_, "a line\n");
  std::ifstream file = open_for_reading(path_);
  std::string line;
  EXPECT_TRUE(std::getline(file, line));
  EXPECT_EQ(line, "a line");
}

TEST_F(InputFile, SaysWhatIsWrongWithAMissingFileAndAFolder) {
  EXPECT_EQ(file_error_of([&] { open_for_reading(path_); }),
            "cannot read " + path_.string() +
                ": No such file or directory; check the path and the permissions");
  EXPECT_EQ(file_error_of([&] { open_for_reading(folder_.path()); }),
            "cannot read " + folder_.path().string() + ": it is a folder; name the file in it");
}

class NamelessFileIn : public Files {};

TEST_F(NamelessFileIn, HasNoNameAndGivesBackWhatWasWritten) {
  NamelessFile file(folder_.path() / "made_for_it");
  EXPECT_TRUE(fs::is_directory(folder_.path() / "made_for_it"));
  EXPECT_TRUE(fs::is_empty(folder_.path() / "made_for_it"));
  const std::string text = "0123456789";
  file.write(0, text.data(), text.size());
  file.write(100, text.data(), text.size());
  file.write(3, "abc", 3);
  std::string read(10, ' ');
  file.read(0, read.data(), read.size());
  EXPECT_EQ(read, "012abc6789");
  file.read(100, read.data(), read.size());
  EXPECT_EQ(read, text);
  file.read(50, read.data(), read.size());
  EXPECT_EQ(read, std::string(10, '\0')) << "between the two";
  file.read(0, read.data(), 0);
}

TEST_F(NamelessFileIn, EndsWhereWasWrittenLast) {
  const NamelessFile file(folder_.path());
  char byte = 0;
  const std::string message = file_error_of([&] { file.read(0, &byte, 1); });
  EXPECT_NE(message.find("they end too early"), std::string::npos) << message;
}

TEST_F(NamelessFileIn, NeedsAFolder) {
  write_text_atomically(path_, "no folder");
  EXPECT_THROW(NamelessFile file(path_), FileError);
}

TEST_F(NamelessFileIn, HoldsListsByTheirKeys) {
  ListFile<int, std::uint32_t> file(folder_.path());
  EXPECT_FALSE(file.contains(4));
  file.put(4, {1, 2, 4'000'000'000U});
  file.put(0, {});
  file.put(9, {7});
  EXPECT_TRUE(file.contains(4));
  EXPECT_TRUE(file.contains(0)) << "also without values";
  EXPECT_FALSE(file.contains(1));
  EXPECT_EQ(file.keys(), (std::vector<int>{0, 4, 9}));
  EXPECT_EQ(file.get(9), (std::vector<std::uint32_t>{7}));
  EXPECT_EQ(file.get(4), (std::vector<std::uint32_t>{1, 2, 4'000'000'000U}));
  EXPECT_TRUE(file.get(0).empty());
}

// Headers of PCD files.

class PcdHeaderOf : public Files {
 protected:
  PcdHeader read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_pcd_header(path_);
  }
  /// What is wrong with a file; empty if nothing is.
  std::string problem(const std::string& text) {
    return file_error_of([&] { read(text); });
  }
  /// A file of two points, with one line of its header replaced.
  static std::string with(const std::string& line) { return with(first_word(line), line + "\n"); }
  static std::string without(const std::string& key) { return with(key, ""); }

 private:
  static std::string first_word(const std::string& line) { return line.substr(0, line.find(' ')); }
  static std::string with(const std::string& key, const std::string& replacement) {
    std::string text;
    std::istringstream lines(pcd_header(2));
    for (std::string line; std::getline(lines, line);) {
      text += first_word(line) == key ? replacement : line + "\n";
    }
    return text + std::string(2 * 16, '\0');
  }
};

TEST_F(PcdHeaderOf, OwnFilesIsReadBack) {
  const PcdHeader header = read(pcd_header(2) + std::string(2 * 16, '\0'));
  EXPECT_EQ(header.text, pcd_header(2)) << "up to the points";
  EXPECT_EQ(header.points, 2U);
  EXPECT_EQ(header.width, 2U);
  EXPECT_EQ(header.data, "binary");
  EXPECT_EQ(header.step(), 16U);
  EXPECT_TRUE(header.has_float_coordinates());
  EXPECT_FALSE(header.has_more_fields());
}

TEST_F(PcdHeaderOf, OtherProgramsHasOtherFields) {
  const PcdHeader header = read(
      "# comment\n\nFIELDS x y z ring descriptor\nSIZE 8 4 4 2 4\nTYPE F F F U F\nCOUNT 1 1 1 1 "
      "33\n"
      "WIDTH 2\nHEIGHT 3\nPOINTS 6\nDATA ascii\n" +
      std::string(1000, '0'));
  EXPECT_EQ(header.points, 6U);
  EXPECT_EQ(header.width, 2U);
  EXPECT_EQ(header.step(), 8U + 4U + 4U + 2U + 4U * 33U);
  EXPECT_FALSE(header.has_float_coordinates()) << "x has eight bytes";
  EXPECT_TRUE(header.has_more_fields());
}

TEST_F(PcdHeaderOf, AFileMayLackSomeLines) {
  for (const char* key : {"VERSION", "COUNT", "VIEWPOINT", "#"}) {
    EXPECT_EQ(problem(without(key)), "") << key;
  }
  for (const char* key : {"FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT", "POINTS"}) {
    EXPECT_NE(problem(without(key)), "") << key;
  }
  EXPECT_NE(problem("").find("no line DATA"), std::string::npos);
}

TEST_F(PcdHeaderOf, ADamagedFileNamesTheLine) {
  const std::vector<std::pair<std::string, std::string>> damages = {
      {"FIELDS", ":3: FIELDS names none"},
      {"SIZE 4 4 4", ":4: SIZE has 3 words for 4 FIELDS"},
      {"SIZE 4 4 4 3", ":4: SIZE is to be 1, 2, 4 or 8"},
      {"TYPE F F F X", ":5: TYPE X of 4 bytes"},
      {"COUNT 1 1 1 0", ":6: COUNT is to be between 1"},
      {"WIDTH 2 2", ":7: WIDTH is to have one number"},
      {"WIDTH -2", ":7: WIDTH: '-2' is no number"},
      {"HEIGHT two", ":8: HEIGHT: 'two' is no number"},
      {"VIEWPOINT 0 0 0 1 0 0", ":9: VIEWPOINT is to have seven numbers"},
      {"VIEWPOINT 0 0 0 1 0 0 nan", ":9: VIEWPOINT: 'nan' is no finite number"},
      {"POINTS 3", ":10: POINTS is 3, but WIDTH 2 and HEIGHT 1"},
      {"DATA text", ":11: DATA is to be ascii"}};
  for (const auto& [line, expected] : damages) {
    const std::string found = problem(with(line));
    EXPECT_NE(found.find(path_.string() + expected), std::string::npos) << line << ": " << found;
  }
}

TEST_F(PcdHeaderOf, LinesHaveAnOrder) {
  EXPECT_NE(problem("FIELDS x y z\nTYPE F F F\nSIZE 4 4 4\n").find("there is no line SIZE"),
            std::string::npos);
  EXPECT_NE(problem("FIELDS x y z\nSIZE 4 4 4\nSIZE 4 4 4\n").find("is given twice"),
            std::string::npos);
}

TEST_F(PcdHeaderOf, AFileHoldsAllOfItsPoints) {
  const std::string whole = with("DATA binary");
  EXPECT_EQ(problem(whole), "");
  EXPECT_NE(problem(whole.substr(0, whole.size() - 1)).find("31 bytes for 2 points of 16"),
            std::string::npos);
  EXPECT_NE(problem(with("DATA binary_compressed")).find("size of the compressed points"),
            std::string::npos);
  EXPECT_EQ(problem(pcd_header(0)), "") << "none of none";
}

}  // namespace
}  // namespace lidar_mapping
