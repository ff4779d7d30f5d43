// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "clouds/ouster_metadata.hpp"
#include "clouds/ouster_turns.hpp"
#include "ouster_turn.hpp"

namespace lidar_mapping::ros_border {
namespace {

class OusterTurnsOfPackets : public testing::Test {
 protected:
  /// Numbers of turns begin anew behind 65535, which is that of turn 0 here.
  void add(std::size_t turn, std::size_t index, std::uint64_t fault = 0) {
    const auto bytes = test::packet_of_turn(sensor_, static_cast<std::uint16_t>(65535 + turn),
                                            index, (1000 + turn) * test::kOusterTurn + fault);
    take(turns_.add({bytes.data(), bytes.size()}, from_seconds(100.0), {}));
  }
  void finish() { take(turns_.finish({})); }

  const test::OusterSensor sensor_ = test::small_ouster();
  OusterTurns turns_{preprocessing::OusterDecoder(ouster_format(sensor_.metadata()))};
  std::vector<std::uint32_t> points_, numbers_;  // of the turns

 private:
  void take(const std::optional<OusterTurn>& turn) {
    if (!turn) return;
    points_.push_back(turn->cloud.width);
    numbers_.push_back(turn->cloud.header.seq);
  }
};

TEST_F(OusterTurnsOfPackets, OneThatComesLateDoesNotDivideTheNextTurn) {
  for (const std::size_t index : {0U, 1U, 2U}) add(0, index);
  add(1, 0);
  add(0, 3);  // too late
  for (const std::size_t index : {1U, 2U, 3U}) add(1, index);
  add(2, 0);
  EXPECT_EQ(points_, (std::vector<std::uint32_t>{48, 64}));
  EXPECT_EQ(numbers_, (std::vector<std::uint32_t>{65535, 0}));
  EXPECT_EQ(turns_.late_packets(), 1U);
}

TEST_F(OusterTurnsOfPackets, OneOfATurnThatWasFinishedComesLate) {
  for (const std::size_t index : {0U, 1U, 3U}) add(0, index);
  finish();
  finish();
  EXPECT_EQ(points_, (std::vector<std::uint32_t>{48})) << "given once";
  add(0, 2);
  EXPECT_EQ(turns_.late_packets(), 1U);
  EXPECT_EQ(turns_.packets_so_far(), 0U);
  for (const std::size_t index : {0U, 1U, 2U, 3U}) add(1, index);
  add(2, 0);
  EXPECT_EQ(points_, (std::vector<std::uint32_t>{48, 64}));
  EXPECT_EQ(turns_.late_packets(), 1U);
}

TEST_F(OusterTurnsOfPackets, LosesOnlyThePacketWhoseTimeIsDamaged) {
  for (const std::size_t damaged : {0U, 1U, 2U, 3U}) {
    for (const std::size_t index : {0U, 1U, 2U, 3U}) {
      add(damaged, index, index == damaged ? 1000 * test::kOusterTurn : 0);
    }
  }
  add(4, 0);
  EXPECT_EQ(points_, (std::vector<std::uint32_t>{48, 48, 48, 48}));
}

TEST_F(OusterTurnsOfPackets, AnUnfinishedTurnWaitsForItsEnd) {
  for (const std::size_t index : {0U, 1U, 2U}) add(0, index);
  finish();
  EXPECT_TRUE(points_.empty());
  EXPECT_EQ(turns_.packets_so_far(), 3U);
  add(0, 3);
  finish();
  EXPECT_EQ(points_, (std::vector<std::uint32_t>{64}));
  EXPECT_EQ(turns_.packets_so_far(), 0U);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
