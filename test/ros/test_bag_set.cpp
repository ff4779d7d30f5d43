// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/bag_set.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

std::string refusal(const std::string& path) {
  return test::error_text<FileError>([&] { BagSet({path}); });
}

std::string write_bag(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  std_msgs::String message;
  message.data = std::string(1000, 'x');
  bag.write("/text", ros::Time(1.0), message);
  return path;
}

}  // namespace

TEST(BagSet, KnowsTopicsAndTimes) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.bag").string();
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (const std::uint32_t second : {3U, 1U, 2U}) {
    bag.write("/text", ros::Time(second), std_msgs::String());
  }
  bag.write("/other", ros::Time(9), std_msgs::String());
  bag.close();
  const BagSet bags({path});
  ASSERT_EQ(bags.topics().size(), 2U);
  EXPECT_EQ(bags.topics()[1].name, "/text");
  EXPECT_EQ(bags.topics()[1].messages, 3U);
  EXPECT_TRUE(bags.has("/text", {"std_msgs/Header", "std_msgs/String"}));
  EXPECT_FALSE(bags.has("/text", {"std_msgs/Header"}));
  EXPECT_EQ(bags.times_of({"/text"})->first, from_seconds(1.0));
  EXPECT_EQ(bags.times_of({"/text"})->second, from_seconds(3.0));
  EXPECT_FALSE(bags.times_of({"/none"}));
}

// As an interrupted copy leaves it.
TEST(BagSet, SaysThatTheEndIsMissing) {
  const test::TemporaryFolder folder;
  const std::string path = write_bag((folder.path() / "cut.bag").string());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_NE(refusal(path).find("its end is missing"), std::string::npos) << refusal(path);
}

TEST(BagSet, SaysWhatToDoAboutAFileThatCannotBeRead) {
  const test::TemporaryFolder folder;
  const std::string missing = (folder.path() / "missing.bag").string();
  EXPECT_NE(refusal(missing).find("no such file"), std::string::npos);
  const std::string text = (folder.path() / "text.bag").string();
  std::ofstream(text) << "no bag\n";
  EXPECT_NE(refusal(text).find("no bag"), std::string::npos);
  EXPECT_EQ(refusal(text).find("reindex"), std::string::npos);
  const std::string packed = (folder.path() / "packed.bag.gz").string();
  std::ofstream(packed, std::ios::binary) << "\x1f\x8b\x08 and what was packed";
  EXPECT_NE(refusal(packed).find("it is packed; unpack it with gunzip"), std::string::npos)
      << refusal(packed);
}

// roscpp's reader of such headers believes the length and reads on in whatever memory comes next.
TEST(BagSet, RefusesAFieldThatIsLongerThanItsHeader) {
  const test::TemporaryFolder folder;
  const std::string path = write_bag((folder.path() / "long.bag").string());
  std::string bytes = test::content_of(path);
  const std::size_t type = bytes.rfind("type=std_msgs/String");
  ASSERT_NE(type, std::string::npos);
  bytes[type - 4] = static_cast<char>(bytes[type - 4] + 2);
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_NE(refusal(path).find("damaged"), std::string::npos) << refusal(path);
}

// As a recording that was killed leaves it: the header does not yet say where the index is.
TEST(BagSet, NamesTheRemedyForARecordingThatWasBrokenOff) {
  const test::TemporaryFolder folder;
  const std::string path = write_bag((folder.path() / "killed.bag").string());
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  std::string start(200, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  const std::string key = "index_pos=";
  const std::size_t at = start.find(key);
  ASSERT_NE(at, std::string::npos);
  file.seekp(static_cast<std::streamoff>(at + key.size()));
  file.write("\0\0\0\0\0\0\0\0", 8);
  file.close();
  EXPECT_NE(refusal(path).find("rosbag reindex"), std::string::npos);
}

}  // namespace lidar_mapping::ros_border
