// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/ouster_feed.hpp"
#include "lidar_mapping/ros/recording_check.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

#include "ouster_packet_message.hpp"
#include "ouster_turn.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kBegin = 1'700'000'000'000'000'000;  // ns
constexpr Stamp kDelay = 2'000'000;                  // ns, from a packet's end to when it comes
constexpr std::uint16_t kFirstFrame = 65534;         // it begins anew soon

/// As it comes from a driver.
struct Packet {
  test::OusterPacketMessage message;
  Stamp received = 0;

  std::vector<std::uint8_t> serialized() const {
    std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
    ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    ros::serialization::serialize(stream, message);
    return bytes;
  }
};

/// The feed of a small sensor, and what it has given.
class OusterFeeds : public testing::Test {
 protected:
  /// A packet of the sensor, whose clock is `ahead_`.
  Packet packet(std::size_t turn, std::size_t index) const {
    const Stamp begin = kBegin + static_cast<Stamp>(turn * test::kOusterTurn);
    const auto part = static_cast<Stamp>(test::kOusterTurn / test::packets_in_turn(sensor_));
    return {{test::packet_of_turn(sensor_, static_cast<std::uint16_t>(kFirstFrame + turn), index,
                                  static_cast<std::uint64_t>(begin + ahead_))},
            begin + static_cast<Stamp>(index + 1) * part + kDelay};
  }
  Packet imu_packet(std::size_t turn) const {
    const Stamp stamp = kBegin + static_cast<Stamp>(turn * test::kOusterTurn);
    return {{test::ouster_imu_packet(static_cast<std::uint64_t>(stamp + ahead_), {0.0, 0.0, 1.0},
                                     {0.0, 0.0, 10.0})},
            stamp + kDelay};
  }
  void add(const Packet& packet) {
    const std::vector<std::uint8_t> bytes = packet.serialized();
    keep(feed_.add_points({bytes.data(), bytes.size()}, packet.received));
  }
  void add(std::size_t turn, std::size_t index) { add(packet(turn, index)); }
  void add_turn(std::size_t turn) {
    for (std::size_t i = 0; i < test::packets_in_turn(sensor_); ++i) add(turn, i);
  }
  sensor_msgs::Imu imu_in(const Packet& packet) {
    const std::vector<std::uint8_t> bytes = packet.serialized();
    return feed_.imu_in({bytes.data(), bytes.size()}, packet.received);
  }
  void set_metadata() {
    for (RecordedCloud& cloud : feed_.set_metadata(sensor_.metadata())) keep(std::move(cloud));
  }
  void finish() { keep(feed_.finish()); }
  std::vector<std::uint32_t> widths() const {
    std::vector<std::uint32_t> widths;
    for (const RecordedCloud& cloud : clouds_) widths.push_back(cloud.message.width);
    return widths;
  }

  /// One packet comes again, behind the first one of the next turn.
  BagSet recording_with_a_late_packet() const {
    std::vector<Packet> late = {packet(0, 3)};
    late.back().received = packet(1, 0).received + 1;
    return recording(late);
  }
  /// What a recording of the same packets gives.
  BagSet recording(const std::vector<Packet>& others = {}) const {
    const std::string path = folder_.path() / "drive.bag";
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    std_msgs::String metadata;
    metadata.data = sensor_.metadata();
    bag.write("/os/metadata", to_ros(kBegin), metadata);
    for (std::size_t turn = 0; turn < kTurns; ++turn) {
      const Packet imu = imu_packet(turn);
      bag.write("/os/imu_packets", to_ros(imu.received), imu.message);
      for (std::size_t i = 0; i < test::packets_in_turn(sensor_); ++i) {
        const Packet points = packet(turn, i);
        bag.write("/os/lidar_packets", to_ros(points.received), points.message);
      }
    }
    for (const Packet& other : others) {
      bag.write("/os/lidar_packets", to_ros(other.received), other.message);
    }
    bag.close();
    return BagSet({path});
  }
  void expect_the_clouds_of(const BagSet& bags) const {
    BagStream messages = bags.messages_of({"/os/lidar_packets"});
    for (const RecordedCloud& cloud : clouds_) {
      const auto message = messages.next();
      ASSERT_TRUE(message);
      const auto recorded = read_cloud(*message);
      ASSERT_TRUE(recorded);
      EXPECT_EQ(cloud.message, recorded->message);
      ASSERT_EQ(cloud.data.size, recorded->data.size);
      EXPECT_EQ(std::memcmp(cloud.data.first, recorded->data.first, cloud.data.size), 0);
    }
    EXPECT_FALSE(messages.next());
  }

  void expect_the_samples_of(const BagSet& bags, const std::vector<sensor_msgs::Imu>& samples) {
    BagStream messages = bags.messages_of({"/os/imu_packets"});
    for (const sensor_msgs::Imu& sample : samples) {
      const auto message = messages.next();
      ASSERT_TRUE(message);
      EXPECT_EQ(message->instantiate<sensor_msgs::Imu>(), sample);
    }
  }
  void expect_what_a_recording_gives() {
    set_metadata();
    std::vector<sensor_msgs::Imu> samples;
    for (std::size_t turn = 0; turn < kTurns; ++turn) {
      samples.push_back(imu_in(imu_packet(turn)));
      add_turn(turn);
    }
    finish();
    EXPECT_EQ(clouds_.size(), kTurns);
    const BagSet bags = recording();
    expect_the_clouds_of(bags);
    expect_the_samples_of(bags, samples);
    EXPECT_EQ(feed_.losses().total(), 0U);
  }

  static constexpr std::size_t kTurns = 4;
  const test::OusterSensor sensor_ = test::small_ouster();
  Stamp ahead_ = 0;
  OusterFeed feed_;
  std::vector<RecordedCloud> clouds_;

 private:
  void keep(std::optional<RecordedCloud> cloud) {
    if (cloud) clouds_.push_back(std::move(*cloud));
  }

  const test::TemporaryFolder folder_;
};

TEST_F(OusterFeeds, GivesWhatARecordingGives) { expect_what_a_recording_gives(); }

TEST_F(OusterFeeds, GivesWhatARecordingGivesByAtomicTime) {
  ahead_ = from_seconds(37.0);  // as PTP has it
  expect_what_a_recording_gives();
}

TEST_F(OusterFeeds, AClockOfItsOwnIsFollowed) {
  ahead_ = -kBegin + from_seconds(5.0);
  set_metadata();
  for (std::size_t turn = 0; turn < 3; ++turn) add_turn(turn);
  ASSERT_EQ(clouds_.size(), 2U);
  // A packet is sent when its last column is through, and comes later.
  const Stamp column = static_cast<Stamp>(test::kOusterTurn / sensor_.columns);
  EXPECT_EQ(from_ros(clouds_[1].message.header.stamp),
            kBegin + static_cast<Stamp>(test::kOusterTurn) + column + kDelay);
  EXPECT_EQ(from_ros(imu_in(imu_packet(3)).header.stamp),
            kBegin + 3 * static_cast<Stamp>(test::kOusterTurn) + column + kDelay);
}

TEST_F(OusterFeeds, PacketsWaitForTheMetadata) {
  add_turn(0);
  add_turn(1);
  add(2, 0);
  EXPECT_FALSE(feed_.has_metadata());
  EXPECT_TRUE(clouds_.empty());
  set_metadata();
  EXPECT_TRUE(feed_.has_metadata());
  EXPECT_EQ(widths(), (std::vector<std::uint32_t>{64, 64}));
  set_metadata();  // of a driver that was started again
  for (const std::size_t index : {1U, 2U, 3U}) add(2, index);
  finish();
  EXPECT_EQ(widths(), (std::vector<std::uint32_t>{64, 64, 64}));
  EXPECT_EQ(feed_.losses().total(), 0U);
}

TEST_F(OusterFeeds, WhatWaitsTooLongIsCounted) {
  for (std::size_t turn = 0; turn < 20; ++turn) add_turn(turn);  // of 2 s
  EXPECT_EQ(feed_.losses().total(), 0U);
  add_turn(20);
  EXPECT_EQ(feed_.losses().without_metadata, 3U);
  add(21, 0);
  EXPECT_EQ(feed_.losses().without_metadata, 4U);
  set_metadata();
  EXPECT_EQ(clouds_.size(), 20U) << "without the first";
  EXPECT_EQ(feed_.losses().total(), 4U);
}

TEST_F(OusterFeeds, ABoundedNumberOfPacketsWaits) {
  constexpr std::size_t kWaiting = 2560;
  const auto add_at_once = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      Packet one = packet(0, 0);
      one.received = kBegin;
      add(one);
    }
  };
  add_at_once(kWaiting);
  EXPECT_EQ(feed_.losses().total(), 0U);
  add_at_once(3);
  EXPECT_EQ(feed_.losses().without_metadata, 3U);
}

TEST_F(OusterFeeds, MetadataThatCannotBeUsedAreRefused) {
  add_turn(0);
  EXPECT_THROW(feed_.set_metadata("{ nothing"), InputError);
  EXPECT_FALSE(feed_.has_metadata());
  set_metadata();
  EXPECT_THROW(feed_.set_metadata("{}"), InputError);
  EXPECT_TRUE(feed_.has_metadata()) << "those before stay";
  add(1, 0);
  EXPECT_EQ(widths(), (std::vector<std::uint32_t>{64}));
}

TEST_F(OusterFeeds, DamagedLateAndUnfinishedOnesAreCounted) {
  Packet other = packet(0, 0);
  other.message.buf.resize(10);
  add(other);  // it waits; its size cannot be judged yet
  set_metadata();
  EXPECT_EQ(feed_.losses().damaged, 1U);
  EXPECT_THROW(add(other), InputError);
  const std::vector<std::uint8_t> bytes = packet(0, 0).serialized();
  EXPECT_THROW(feed_.add_points({bytes.data(), bytes.size() - 1}, kBegin), InputError);
  EXPECT_EQ(feed_.losses().damaged, 3U);
  EXPECT_THROW(imu_in(other), InputError);
  add_turn(0);
  add(1, 0);
  add(0, 3);
  EXPECT_EQ(feed_.losses().late, 1U);
  add(1, 1);
  EXPECT_EQ(feed_.losses().unfinished, 0U) << "its end may still come";
  finish();
  EXPECT_EQ(feed_.losses().unfinished, 2U);
  EXPECT_EQ(feed_.losses().total(), 6U);
  add(1, 3);
  finish();
  EXPECT_EQ(feed_.losses().unfinished, 0U) << "it came";
  EXPECT_EQ(widths(), (std::vector<std::uint32_t>{64, 48}));
}

TEST_F(OusterFeeds, PacketsOfTheTurnBeforeOtherMetadataAreCounted) {
  set_metadata();
  add_turn(0);
  for (const std::size_t index : {0U, 1U}) add(1, index);
  EXPECT_EQ(feed_.set_metadata(sensor_.metadata() + " ").size(), 0U);
  EXPECT_EQ(feed_.losses().unfinished, 2U);
  add_turn(2);
  add(3, 0);
  EXPECT_EQ(feed_.losses().unfinished, 2U) << "these never get their end";
  finish();
  EXPECT_EQ(feed_.losses().unfinished, 3U);
  EXPECT_EQ(feed_.losses().total(), 3U);
  EXPECT_EQ(widths(), (std::vector<std::uint32_t>{64, 64}));
}

TEST_F(OusterFeeds, AWholeTurnBeforeOtherMetadataIsGivenOut) {
  set_metadata();
  add_turn(0);
  EXPECT_TRUE(clouds_.empty());
  const std::vector<RecordedCloud> clouds = feed_.set_metadata(sensor_.metadata() + " ");
  ASSERT_EQ(clouds.size(), 1U);
  EXPECT_EQ(clouds.front().message.width, 64U);
  EXPECT_EQ(feed_.losses().total(), 0U);
}

TEST_F(OusterFeeds, LatePacketsOfARecordingAreCounted) {
  const auto late_in = [](const BagSet& bags) {
    BagStream messages = bags.messages_of({"/os/lidar_packets"});
    while (messages.next()) {
    }
    return messages.late_packets();
  };
  EXPECT_EQ(late_in(recording()), 0U);
  EXPECT_EQ(late_in(recording_with_a_late_packet()), 1U);
}

TEST_F(OusterFeeds, TheCheckOfARecordingNamesLatePackets) {
  const auto names_late_packets = [](const BagSet& bags) {
    RecordingCheck recording;
    recording.bags = &bags;
    recording.topics = topics_in(bags);
    const auto reports = check(recording, {});
    const auto& found = reports.front().diagnostics;
    return std::any_of(found.begin(), found.end(), [](const auto& diagnostic) {
      return diagnostic.text == "1 packets of the sensor came behind their turn";
    });
  };
  EXPECT_FALSE(names_late_packets(recording()));
  EXPECT_TRUE(names_late_packets(recording_with_a_late_packet()));
}

}  // namespace
}  // namespace lidar_mapping::ros_border
