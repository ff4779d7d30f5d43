// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "clouds/ouster_metadata.hpp"
#include "clouds/ouster_turns.hpp"
#include "ouster_encoder.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr std::uint64_t kTurn = 100'000'000;  // ns

/// A turn has four packets of eight columns with two points.
test::OusterSensor small_sensor() {
  test::OusterSensor sensor;
  sensor.columns = 32;
  sensor.altitudes_deg = {-5.0, 5.0};
  sensor.azimuths_deg = {0.0, 0.0};
  return sensor;
}

/// Numbers of turns begin anew behind 65535, which is that of turn 0 here.
std::vector<std::uint8_t> packet(const test::OusterSensor& sensor, std::size_t turn,
                                 std::size_t index) {
  const std::size_t first = index * sensor.columns_per_packet;
  const std::uint64_t step = kTurn / sensor.columns;
  return test::ouster_packet(sensor, static_cast<std::uint16_t>(65535 + turn), first,
                             (1000 + turn) * kTurn + first * step, step,
                             [](std::size_t, std::size_t) {
                               return test::OusterReturn{5000, 7};
                             });
}

TEST(OusterTurns, APacketThatComesLateDoesNotDivideTheNextTurn) {
  const test::OusterSensor sensor = small_sensor();
  OusterTurns turns(preprocessing::OusterDecoder(ouster_format(sensor.metadata())));
  std::vector<std::uint32_t> points;
  const auto add = [&](std::size_t turn, std::size_t index) {
    const std::vector<std::uint8_t> bytes = packet(sensor, turn, index);
    const auto complete = turns.add({bytes.data(), bytes.size()}, from_seconds(100.0), {});
    if (complete) points.push_back(complete->cloud.width);
  };
  for (const std::size_t index : {0U, 1U, 2U}) add(0, index);
  add(1, 0);
  add(0, 3);  // too late
  for (const std::size_t index : {1U, 2U, 3U}) add(1, index);
  add(2, 0);
  EXPECT_EQ(points, (std::vector<std::uint32_t>{48, 64}));
}

}  // namespace
}  // namespace lidar_mapping::ros_border
