// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <lz4frame.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/Header.h>
#include <std_msgs/String.h>
#include <sys/resource.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/bag_stream.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bags/bag_chunk.hpp"
#include "file_content.hpp"
#include "ros2_writer.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Strings = std::vector<std::string>;

const Strings kTopics = {"/a", "/b", "/c"};
constexpr std::size_t kMessages = 150;  // of each topic

struct Written {
  std::string topic;
  std::string text;
  ros::Time time;
};

/// Texts of different lengths, some of which no compression makes smaller. No two times are equal.
std::vector<Written> some_messages(std::mt19937& engine) {
  std::vector<Written> messages;
  std::uniform_int_distribution<int> letter('a', 'z'), length(0, 3000), jitter(0, 90'000'000);
  for (std::uint32_t i = 0; i < kMessages; ++i) {
    for (std::uint32_t topic = 0; topic < kTopics.size(); ++topic) {
      std::string text(static_cast<std::size_t>(length(engine)), 'x');
      if (topic == 0) std::generate(text.begin(), text.end(), [&] { return letter(engine); });
      const auto noise = static_cast<std::uint32_t>(jitter(engine)) * 10 + topic;
      messages.push_back({kTopics[topic], text, ros::Time(100 + i / 5, noise)});
    }
  }
  return messages;
}

void write_bag(const std::string& path, const std::vector<Written>& messages,
               rosbag::compression::CompressionType compression) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(20'000);
  for (const Written& message : messages) {
    std_msgs::String string;
    string.data = message.text;
    bag.write(message.topic, message.time, string);
  }
  bag.close();
}

std::string text_of(const BagMessage& message) {
  return message.instantiate<std_msgs::String>()->data;
}

/// "topic time text" of each message.
Strings streamed(const Strings& paths, const Strings& topics, Stamp from = 0) {
  BagStream stream(paths, topics);
  if (from != 0) stream.skip_to(from);
  Strings result;
  while (const auto message = stream.next()) {
    result.push_back(message->connection->topic + " " + std::to_string(message->recorded) + " " +
                     text_of(*message));
  }
  return result;
}

Strings viewed(const Strings& paths, const Strings& topics, Stamp from = 0) {
  std::vector<std::unique_ptr<rosbag::Bag>> bags;
  rosbag::View view;
  for (const std::string& path : paths) {
    bags.push_back(std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read));
    view.addQuery(*bags.back(), rosbag::TopicQuery(topics));
  }
  Strings result;
  for (const rosbag::MessageInstance& message : view) {
    const auto time = static_cast<Stamp>(message.getTime().toNSec());
    if (time < from) continue;
    result.push_back(message.getTopic() + " " + std::to_string(time) + " " +
                     message.instantiate<std_msgs::String>()->data);
  }
  return result;
}

class BagStreamTest : public testing::TestWithParam<rosbag::compression::CompressionType> {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  std::mt19937 engine_{7};
  test::TemporaryFolder folder_;
};

TEST_P(BagStreamTest, GivesWhatRosbagGivesOfMessagesOutOfOrder) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  EXPECT_EQ(streamed({path("a.bag")}, kTopics).size(), kMessages * kTopics.size());
  for (const Strings& topics : {kTopics, Strings{"/b"}, Strings{"/c", "/a", "/none", ""}}) {
    EXPECT_EQ(streamed({path("a.bag")}, topics), viewed({path("a.bag")}, topics));
  }
}

TEST_P(BagStreamTest, MergesTopicsThatWereWrittenOneAfterTheOther) {
  auto messages = some_messages(engine_);
  std::stable_sort(messages.begin(), messages.end(),
                   [](const Written& a, const Written& b) { return a.topic < b.topic; });
  write_bag(path("a.bag"), messages, GetParam());
  EXPECT_EQ(streamed({path("a.bag")}, kTopics), viewed({path("a.bag")}, kTopics));
}

TEST_P(BagStreamTest, ReadsAgainWhatItDiscarded) {
  auto messages = some_messages(engine_);
  std::shuffle(messages.begin(), messages.end(), engine_);
  write_bag(path("a.bag"), messages, GetParam());
  EXPECT_EQ(streamed({path("a.bag")}, kTopics), viewed({path("a.bag")}, kTopics));
}

TEST_P(BagStreamTest, MergesBags) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  write_bag(path("b.bag"), some_messages(engine_), GetParam());
  const Strings paths = {path("a.bag"), path("b.bag")};
  EXPECT_EQ(streamed(paths, kTopics), viewed(paths, kTopics));
}

TEST_P(BagStreamTest, BeginsWhereItIsTold) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  const Stamp stamp = from_seconds(115.5);
  const Strings rest = streamed({path("a.bag")}, kTopics, stamp);
  EXPECT_FALSE(rest.empty());
  EXPECT_EQ(rest, viewed({path("a.bag")}, kTopics, stamp));
}

TEST_P(BagStreamTest, LeavesMessagesWhereTheyAre) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  BagStream stream({path("a.bag")}, kTopics);
  const auto first = stream.next();
  const std::string text = text_of(*first);
  while (stream.next()) continue;
  EXPECT_EQ(text_of(*first), text);
}

TEST_P(BagStreamTest, KnowsTypes) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  BagStream stream({path("a.bag")}, kTopics);
  const auto message = stream.next();
  EXPECT_EQ(message->getDataType(), "std_msgs/String");
  EXPECT_TRUE(message->is<std_msgs::String>());
  EXPECT_FALSE(message->instantiate<std_msgs::Header>());
}

/// Whatever is read then, it ends, and errors are those of a file.
TEST_P(BagStreamTest, OutlivesDamage) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  std::uniform_int_distribution<std::uintmax_t> place(
      0, std::filesystem::file_size(path("a.bag")) - 1);
  int refused = 0;
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::filesystem::copy_file(path("a.bag"), path("b.bag"),
                               std::filesystem::copy_options::overwrite_existing);
    {
      std::fstream file(path("b.bag"), std::ios::in | std::ios::out | std::ios::binary);
      for (int i = 0; i < 20; ++i) {
        file.seekp(static_cast<std::streamoff>(place(engine_)));
        file.put(static_cast<char>(engine_()));
      }
    }
    if (attempt % 10 == 0) std::filesystem::resize_file(path("b.bag"), place(engine_));
    try {
      BagStream stream({path("b.bag")}, kTopics);
      while (stream.next()) continue;
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GE(refused, 10);
}

void overwrite(const std::string& path, std::uintmax_t place, const std::string& bytes) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(place));
  file << bytes;
}

TEST_P(BagStreamTest, LosesOnlyWhatIsDamaged) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  const Strings whole = streamed({path("a.bag")}, kTopics);
  overwrite(path("a.bag"), std::filesystem::file_size(path("a.bag")) / 3,
            std::string(4000, '\xFF'));
  BagStream stream({path("a.bag")}, kTopics);
  std::size_t left = 0;
  while (stream.next()) ++left;
  EXPECT_LT(left, whole.size());
  EXPECT_GT(left, whole.size() - whole.size() / 4);
  EXPECT_GE(stream.damage().places, 1U);
  EXPECT_GT(stream.damage().first, from_seconds(100.0));
  EXPECT_NE(stream.damage().reason.find("damaged"), std::string::npos) << stream.damage().reason;
}

/// Of each bit that is turned over rosbag's checksums tell, where a bag has them.
TEST_P(BagStreamTest, GivesNothingThatWasNotWritten) {
  if (GetParam() == rosbag::compression::Uncompressed) GTEST_SKIP() << "no checksums";
  const auto messages = some_messages(engine_);
  write_bag(path("a.bag"), messages, GetParam());
  std::set<std::string> written;
  for (const Written& message : messages) written.insert(message.text);
  std::uniform_int_distribution<std::uintmax_t> place(
      5000, std::filesystem::file_size(path("a.bag")) / 2);
  std::size_t damaged = 0;
  for (int attempt = 0; attempt < 60; ++attempt) {
    std::filesystem::copy_file(path("a.bag"), path("b.bag"),
                               std::filesystem::copy_options::overwrite_existing);
    const std::uintmax_t at = place(engine_);
    std::ifstream file(path("a.bag"), std::ios::binary);
    file.seekg(static_cast<std::streamoff>(at));
    overwrite(path("b.bag"), at, std::string(1, static_cast<char>(file.get() ^ 1)));
    BagStream stream({path("b.bag")}, kTopics);
    while (const auto message = stream.next()) {
      ASSERT_EQ(written.count(text_of(*message)), 1U) << at;
    }
    damaged += stream.damage().places > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 30U);
}

/// The header of a frame and its blocks have checksums too: no bit of a chunk may be wrong.
TEST(BagChunk, ABitAnywhereInAnLz4FrameIsNoticed) {
  for (const auto flags : {LZ4F_noBlockChecksum, LZ4F_blockChecksumEnabled}) {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.blockMode = LZ4F_blockIndependent;
    preferences.frameInfo.blockChecksumFlag = flags;
    preferences.frameInfo.contentChecksumFlag =
        flags == LZ4F_noBlockChecksum ? LZ4F_contentChecksumEnabled : LZ4F_noContentChecksum;
    std::string text(3000, 'x');
    std::mt19937 engine(3);
    std::generate(text.begin(), text.begin() + 1000, [&] { return static_cast<char>(engine()); });
    std::vector<std::uint8_t> frame(LZ4F_compressFrameBound(text.size(), &preferences));
    frame.resize(
        LZ4F_compressFrame(frame.data(), frame.size(), text.data(), text.size(), &preferences));
    std::vector<std::uint8_t> content(text.size());
    decompress("lz4", {frame.data(), frame.size()}, content.data(), content.size());
    EXPECT_EQ(std::string(content.begin(), content.end()), text);
    std::size_t refused = 0;
    for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
      std::vector<std::uint8_t> damaged = frame;
      damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      try {
        decompress("lz4", {damaged.data(), damaged.size()}, content.data(), content.size());
        // Of a run of equal letters it does not matter from which of them it is copied.
        EXPECT_EQ(std::string(content.begin(), content.end()), text) << "bit " << bit;
      } catch (const InputError&) {
        ++refused;
      }
    }
    const std::size_t bits = 8 * frame.size();
    EXPECT_GE(refused, flags == LZ4F_noBlockChecksum ? bits - 100 : bits);
  }
}

/// While it lives the process may only have so much more address space.
class ScarceMemory {
 public:
  explicit ScarceMemory(std::size_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit now = before_;
    now.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + bytes;
    setrlimit(RLIMIT_AS, &now);
  }
  ~ScarceMemory() { setrlimit(RLIMIT_AS, &before_); }
  ScarceMemory(const ScarceMemory&) = delete;
  ScarceMemory& operator=(const ScarceMemory&) = delete;

 private:
  rlimit before_{};
};

TEST_P(BagStreamTest, RefusesASizeThatAChunkCannotHave) {
  write_bag(path("a.bag"), some_messages(engine_), GetParam());
  const std::string bytes = test::content_of(path("a.bag"));
  overwrite(path("a.bag"), bytes.find("size=") + 5, "\xFF\xFF\xFF\x7F");
  const ScarceMemory scarce(1'000'000'000);
  BagStream stream({path("a.bag")}, kTopics);
  std::size_t left = 0;
  while (stream.next()) ++left;
  EXPECT_GT(left, kMessages);
  EXPECT_EQ(stream.damage().places, 1U);
}

TEST(BagStream, SaysWhatItCannotRead) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "old.bag").string();
  EXPECT_THROW(BagStream({path}, kTopics), FileError);
  std::ofstream(path) << "#ROSBAG V1.2\n and so on";
  try {
    BagStream({path}, kTopics);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("rosbag fix"), std::string::npos) << error.what();
  }
}

/// A database has room for times that no sum of times holds.
TEST(BagStream, ReadsMessagesOfImpossibleTimes) {
  const test::TemporaryFolder folder;
  const Strings paths = {(folder.path() / "a.db3").string()};
  {
    test::Ros2Writer out(paths[0]);
    for (std::uint32_t i = 0; i < 5; ++i) out.add("/imu", ros::Time(100 + i), sensor_msgs::Imu());
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(paths[0].c_str(), &database), SQLITE_OK);
  const char* const damage =
      "UPDATE messages SET timestamp = 9223372036854775807 WHERE id = 2;"
      "UPDATE messages SET timestamp = -9223372036854775807 WHERE id = 4";
  EXPECT_EQ(sqlite3_exec(database, damage, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  BagStream stream(paths, {"/imu"});
  std::vector<Stamp> times;
  while (const auto message = stream.next()) times.push_back(message->recorded);
  const Stamp latest = from_ros(ros::TIME_MAX);
  const std::vector<Stamp> expected = {0, from_seconds(100.0), from_seconds(102.0),
                                       from_seconds(104.0), latest};
  EXPECT_EQ(times, expected);
  EXPECT_EQ(stream.damage().places, 0U);
  const auto range = BagSet(paths).times_of({"/imu"});
  ASSERT_TRUE(range.has_value());
  EXPECT_EQ(range->first, from_seconds(100.0));
  EXPECT_EQ(range->second, from_seconds(104.0));
}

INSTANTIATE_TEST_SUITE_P(All, BagStreamTest,
                         testing::Values(rosbag::compression::Uncompressed,
                                         rosbag::compression::BZ2, rosbag::compression::LZ4));

}  // namespace
}  // namespace lidar_mapping::ros_border
