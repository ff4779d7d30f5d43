// SPDX-License-Identifier: BSD-3-Clause
// Records byte by byte, as the specification has them.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "bags/mcap_records.hpp"

namespace lidar_mapping::ros_border {
namespace {

/// Bytes that are put together: numbers are little-endian, texts and lists have their length first.
class Bytes {
 public:
  Bytes& number(std::uint64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> (8U * i)));
    }
    return *this;
  }
  Bytes& u16(std::uint64_t value) { return number(value, 2); }
  Bytes& u32(std::uint64_t value) { return number(value, 4); }
  Bytes& u64(std::uint64_t value) { return number(value, 8); }
  Bytes& text(const std::string& value) {
    u32(value.size());
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  Bytes& list(const Bytes& content) {
    u32(content.bytes_.size());
    bytes_.insert(bytes_.end(), content.bytes_.begin(), content.bytes_.end());
    return *this;
  }

  std::size_t size() const { return bytes_.size(); }
  /// The first bytes, which have to outlive the range.
  ByteRange first(std::size_t count) const { return {bytes_.data(), count}; }
  ByteRange all() const { return first(size()); }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Each record that is cut off somewhere is noticed.
template <typename Parse>
void expect_whole(const Bytes& bytes, const Parse& parse) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(parse(bytes.first(size)), InputError) << size << " bytes";
  }
}

TEST(McapReader, ReadsLittleEndianNumbersAndTexts) {
  Bytes bytes;
  bytes.u16(0x0201).u32(0x06050403).u64(0x0E0D0C0B0A090807).text("abc").u16(7);
  McapReader reader(bytes.all());
  EXPECT_EQ(reader.u16(), 0x0201U);
  EXPECT_EQ(reader.u32(), 0x06050403U);
  EXPECT_EQ(reader.position(), 6U);
  EXPECT_EQ(reader.u64(), 0x0E0D0C0B0A090807U);
  EXPECT_EQ(reader.text(), "abc");
  EXPECT_EQ(reader.left(), 2U);
  EXPECT_THROW(reader.bytes(3), InputError);
  EXPECT_EQ(reader.left(), 2U) << "nothing was taken";
  EXPECT_EQ(reader.bytes(2).first[0], 7);
  EXPECT_THROW(reader.u16(), InputError);
}

TEST(McapReader, RefusesLengthsBeyondTheEnd) {
  Bytes bytes;
  bytes.u32(0xFFFFFFFF).u32(0);
  McapReader text(bytes.all());
  EXPECT_THROW(text.text(), InputError);
  McapReader whole(bytes.all());
  EXPECT_THROW(whole.bytes(0xFFFFFFFFFFFFFFFF), InputError);
}

TEST(McapReader, TakesTimesThatRosCanHold) {
  const std::uint64_t last = 4'294'967'295'999'999'999U;  // 2^32 s less 1 ns
  Bytes bytes;
  bytes.u64(1'700'000'000'123'456'789U).u64(last).u64(last + 1);
  McapReader reader(bytes.all());
  EXPECT_EQ(reader.time(), 1'700'000'000'123'456'789);
  EXPECT_EQ(reader.time(), static_cast<Stamp>(last));
  EXPECT_THROW(reader.time(), InputError);
}

TEST(McapRecords, NameTypesAndTopics) {
  Bytes schema;
  schema.u16(3).text("sensor_msgs/msg/Imu").text("ros2msg").text("");
  EXPECT_EQ(mcap_schema(schema.all()).id, 3);
  EXPECT_EQ(mcap_schema(schema.all()).name, "sensor_msgs/msg/Imu");
  Bytes channel;
  channel.u16(5).u16(3).text("/imu").text("cdr");
  const McapChannel imu = mcap_channel(channel.all());
  EXPECT_EQ(imu.id, 5);
  EXPECT_EQ(imu.schema, 3);
  EXPECT_EQ(imu.topic, "/imu");
  EXPECT_EQ(imu.encoding, "cdr");
  expect_whole(channel, mcap_channel);
}

TEST(McapRecords, GiveThePositionOfTheContentOfAChunk) {
  Bytes head;
  head.u64(10).u64(20).u64(3000).u32(0xCAFE).text("lz4").u64(1200);
  Bytes chunk = head;
  chunk.number(0, 5);
  McapReader reader(chunk.all());
  const McapChunkHead read = mcap_chunk_head(reader);
  EXPECT_EQ(read.size, 3000U);
  EXPECT_EQ(read.crc, 0xCAFEU);
  EXPECT_EQ(read.compression, "lz4");
  EXPECT_EQ(read.compressed_size, 1200U);
  EXPECT_EQ(reader.left(), 5U) << "the content follows";
  expect_whole(head, [](ByteRange range) {
    McapReader part(range);
    return mcap_chunk_head(part);
  });
}

TEST(McapRecords, ListTheMessagesOfAChunk) {
  Bytes index;
  index.u16(5).list(Bytes().u64(100).u64(0).u64(90).u64(77));
  const McapMessageIndex read = mcap_message_index(index.all());
  EXPECT_EQ(read.channel, 5);
  ASSERT_EQ(read.entries.size(), 2U);
  EXPECT_EQ(read.entries[0].logged, 100);
  EXPECT_EQ(read.entries[0].offset, 0U);
  EXPECT_EQ(read.entries[1].logged, 90);
  EXPECT_EQ(read.entries[1].offset, 77U);
  expect_whole(index, mcap_message_index);
  Bytes odd;
  odd.u16(5).list(Bytes().u64(100).u32(0));
  EXPECT_THROW(mcap_message_index(odd.all()), InputError) << "three quarters of a message";
}

TEST(McapRecords, ListTheChunksAndTheirChannels) {
  Bytes index;
  index.u64(100).u64(200).u64(4096).u64(900);
  index.list(Bytes().u16(5).u64(5000).u16(7).u64(5100)).u64(160);
  const std::size_t known = index.size();
  index.text("zstd").u64(800).u64(2000);
  const McapChunkIndex read = mcap_chunk_index(index.all());
  EXPECT_EQ(read.begin, 100);
  EXPECT_EQ(read.position, 4096U);
  EXPECT_EQ(read.length, 900U);
  EXPECT_EQ(read.index_length, 160U);
  EXPECT_EQ(read.channels, (std::vector<std::uint16_t>{5, 7}));
  EXPECT_NO_THROW(mcap_chunk_index(index.first(known)));
  EXPECT_THROW(mcap_chunk_index(index.first(known - 1)), InputError);
}

TEST(McapRecords, CountTheMessages) {
  Bytes statistics;
  statistics.u64(1234).u16(2).u32(3).u32(4).u32(5).u32(6).u64(100).u64(200);
  statistics.list(Bytes().u16(5).u64(1000).u16(7).u64(234));
  const McapStatistics read = mcap_statistics(statistics.all());
  EXPECT_EQ(read.messages, 1234U);
  EXPECT_EQ(read.chunks, 6U) << "behind channels, attachments and metadata";
  ASSERT_EQ(read.messages_of.size(), 2U);
  EXPECT_EQ(read.messages_of.at(5), 1000U);
  EXPECT_EQ(read.messages_of.at(7), 234U);
  expect_whole(statistics, mcap_statistics);
}

TEST(McapRecords, FollowEachOther) {
  Bytes records;
  records.number(5, 1).u64(2).u16(0xAABB).number(99, 1).u64(0).number(15, 1).u64(4).u16(0);
  McapReader reader(records.all());
  const McapRecord message = next_mcap_record(reader);
  EXPECT_TRUE(message.is(McapKind::kMessage));
  EXPECT_FALSE(message.is(McapKind::kChunk));
  EXPECT_EQ(message.position, 0U);
  ASSERT_EQ(message.content.size, 2U);
  EXPECT_EQ(message.content.first[0], 0xBB);
  const McapRecord unknown = next_mcap_record(reader);
  EXPECT_EQ(unknown.kind, 99);
  EXPECT_EQ(unknown.position, 11U);
  EXPECT_EQ(unknown.content.size, 0U);
  EXPECT_EQ(reader.position(), 20U);
  EXPECT_THROW(next_mcap_record(reader), InputError) << "its content is cut off";
}

}  // namespace
}  // namespace lidar_mapping::ros_border
