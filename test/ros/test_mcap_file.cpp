// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/bag_stream.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "file_content.hpp"
#include "mcap_writer.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

using test::McapOptions;
using test::McapWriter;

constexpr int kMessages = 60;

sensor_msgs::Imu imu(int number) {
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(100 + number, 7);
  message.header.frame_id = "imu";
  message.linear_acceleration.x = 0.5 * number;
  return message;
}

class McapFiles : public ::testing::Test {
 protected:
  std::string path(const std::string& name = "a.mcap") const { return folder_.path() / name; }

  /// Numbers 0, 1 ... on one topic, and some on another.
  std::string written(const McapOptions& options, const std::string& name = "a.mcap") const {
    McapWriter out(path(name), options);
    for (int i = 0; i < kMessages; ++i) {
      out.add("/imu", ros::Time(100 + i), imu(i));
      if (i % 3 == 0) out.add("/other", ros::Time(100 + i), imu(-i));
    }
    return path(name);
  }

  /// Numbers of the messages in the order in which they are read.
  std::vector<double> read(const std::string& file, const std::string& topic = "/imu") {
    BagStream stream({file}, {topic});
    std::vector<double> numbers;
    while (const auto message = stream.next()) {
      const auto imu = message->instantiate<sensor_msgs::Imu>();
      numbers.push_back(imu ? 2.0 * imu->linear_acceleration.x : -1e9);
    }
    damage_ = stream.damage();
    return numbers;
  }
  static std::vector<double> up_to(int end) {
    std::vector<double> numbers;
    for (int i = 0; i < end; ++i) numbers.push_back(i);
    return numbers;
  }
  static void overwrite(const std::string& file, std::size_t position, char byte) {
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
        .seekp(static_cast<std::streamoff>(position))
        .put(byte);
  }
  /// Where the record of this kind number `number` is; walks from the front.
  static std::size_t record(const std::string& file, char kind, int number) {
    const std::string bytes = test::content_of(file);
    for (std::size_t at = 8; at + 9 <= bytes.size();) {
      if (bytes[at] == kind && number-- == 0) return at;
      std::uint64_t length = 0;
      std::memcpy(&length, &bytes[at + 1], sizeof length);
      at += 9 + length;
    }
    ADD_FAILURE() << "no such record";
    return 0;
  }

  test::TemporaryFolder folder_;
  BagDamage damage_;
};

TEST_F(McapFiles, AllFormsGiveTheSameMessages) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    for (const std::size_t chunk_bytes : {0, 1, 2000, 1'000'000}) {
      for (const bool has_indexes : {true, false}) {
        for (const bool has_summary : {true, false}) {
          McapOptions options;
          options.compression = compression;
          options.chunk_bytes = chunk_bytes;
          options.has_message_indexes = has_indexes;
          options.has_summary = has_summary;
          options.has_checksums = has_summary;
          SCOPED_TRACE(std::string(compression) + " " + std::to_string(chunk_bytes) + " " +
                       std::to_string(has_indexes) + std::to_string(has_summary));
          const std::string file = written(options);
          EXPECT_EQ(read(file), up_to(kMessages));
          EXPECT_EQ(damage_.places, 0U) << damage_.reason;
          EXPECT_EQ(read(file, "/other").size(), 20U);
          const BagSet set({file});
          ASSERT_EQ(set.topics().size(), 2U);
          EXPECT_EQ(set.topics()[0].name, "/imu");
          EXPECT_EQ(set.topics()[0].type, "sensor_msgs/Imu");
          EXPECT_EQ(set.topics()[0].messages, 60U);
          EXPECT_EQ(set.topics()[1].messages, 20U);
          const auto times = set.times_of({"/imu"});
          ASSERT_TRUE(times);
          EXPECT_EQ(times->first, 100'000'000'000);
          EXPECT_EQ(times->second, 159'000'000'000);
        }
      }
    }
  }
}

TEST_F(McapFiles, ChunksThatOverlapAreReadInTheOrderOfTime) {
  for (const bool has_indexes : {true, false}) {
    McapOptions options;
    options.compression = "zstd";
    options.chunk_bytes = 1'000'000;
    options.has_message_indexes = has_indexes;
    {
      McapWriter out(path(), options);
      // Each chunk has every tenth message, the last ones first.
      for (int first = 9; first >= 0; --first) {
        for (int i = 50 + first; i >= 0; i -= 10) out.add("/imu", ros::Time(100 + i), imu(i));
        out.end_chunk();
      }
    }
    EXPECT_EQ(read(path()), up_to(60));
    BagStream stream({path()}, {"/imu"});
    stream.skip_to(from_ros(ros::Time(133)));
    ASSERT_EQ(stream.next()->recorded, from_ros(ros::Time(133)));
  }
}

TEST_F(McapFiles, ACutFileIsReadUpToThere) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    for (const std::size_t chunk_bytes : {0, 2000}) {
      McapOptions options;
      options.compression = compression;
      options.chunk_bytes = chunk_bytes;
      const std::string file = written(options);
      const std::size_t middle = std::filesystem::file_size(file) / 2;
      std::filesystem::resize_file(file, middle);
      const std::vector<double> numbers = read(file);
      EXPECT_GT(numbers.size(), 15U);
      EXPECT_LT(numbers.size(), 45U);
      EXPECT_EQ(numbers, up_to(static_cast<int>(numbers.size())));
      EXPECT_EQ(damage_.places, 1U);
      EXPECT_NE(damage_.reason.find(file + ": its end is missing, from byte "), std::string::npos)
          << damage_.reason;
      EXPECT_NEAR(to_seconds(damage_.first), 99.0 + static_cast<double>(numbers.size()), 1.5);
    }
  }
}

TEST_F(McapFiles, ADamagedChunkIsLeftOutAndNamed) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    McapOptions options;
    options.compression = compression;
    options.chunk_bytes = 2000;
    const std::string file = written(options);
    const std::size_t chunk = record(file, 6, 2);
    overwrite(file, chunk + 100, 'x');
    const std::vector<double> numbers = read(file);
    EXPECT_GT(numbers.size(), 40U);
    EXPECT_LT(numbers.size(), 60U);
    EXPECT_EQ(damage_.places, 1U);
    EXPECT_NE(damage_.reason.find("a chunk is damaged"), std::string::npos) << damage_.reason;
    EXPECT_NE(damage_.reason.find("at byte " + std::to_string(chunk)), std::string::npos)
        << damage_.reason;
  }
}

TEST_F(McapFiles, ADamagedSummaryIsNamedAndNotNeeded) {
  const std::string file = written({});
  overwrite(file, record(file, 11, 0) + 12, 'x');
  EXPECT_EQ(read(file), up_to(kMessages));
  EXPECT_EQ(damage_.places, 1U);
  EXPECT_NE(damage_.reason.find("its summary is damaged (its checksum differs)"), std::string::npos)
      << damage_.reason;
}

TEST_F(McapFiles, ADamagedRecordEndsTheReadingFromTheFront) {
  McapOptions options;
  options.has_summary = false;
  const std::string file = written(options);
  const std::size_t chunk = record(file, 6, 2);
  overwrite(file, chunk, '\0');
  EXPECT_GT(read(file).size(), 10U);
  EXPECT_NE(damage_.reason.find("it is damaged from byte " + std::to_string(chunk) + " on"),
            std::string::npos)
      << damage_.reason;
}

TEST_F(McapFiles, AnIndexThatPointsNowhereIsNamed) {
  McapOptions options;
  options.has_checksums = false;
  const std::string file = written(options);
  overwrite(file, record(file, 7, 0) + 9 + 2 + 4 + 8, '\0');  // the first offset
  EXPECT_EQ(read(file).size(), kMessages - 1U);
  EXPECT_NE(damage_.reason.find("no message where the index says so"), std::string::npos)
      << damage_.reason;
}

TEST_F(McapFiles, AnotherSerialisationIsNamed) {
  const std::pair<std::string, std::string> kinds[] = {{"sensor_msgs/msg/Imu", "json"},
                                                       {"sensor_msgs/Imu", "ros1"}};
  for (const auto& [type, encoding] : kinds) {
    { McapWriter(path()).add_bytes("/imu", type, ros::Time(100), {1, 2}, encoding); }
    try {
      BagStream({path()}, {"/imu"});
      FAIL();
    } catch (const FileError& error) {
      const std::string wanted = "topic /imu is serialised as '" + encoding + "', not as cdr";
      EXPECT_NE(std::string(error.what()).find(wanted), std::string::npos) << error.what();
    }
  }
}

TEST_F(McapFiles, MessagesOfUnknownTypesAreOnlyNamed) {
  { McapWriter(path()).add_bytes("/x", "other_msgs/msg/Thing", ros::Time(100), {1, 2}); }
  const BagSet set({path()});
  ASSERT_EQ(set.topics().size(), 1U);
  EXPECT_EQ(set.topics()[0].type, "other_msgs/Thing");
  EXPECT_TRUE(read(path(), "/x").empty());
  EXPECT_EQ(damage_.places, 0U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
