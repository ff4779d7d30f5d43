// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "ouster_encoder.hpp"

// Turns of an Ouster that sees 5 m everywhere.
namespace lidar_mapping::test {

constexpr std::uint64_t kOusterTurn = 100'000'000;  // ns
constexpr double kOusterRange = 5.0;                // m

/// A turn has four packets of eight columns with two points.
inline OusterSensor small_ouster() {
  OusterSensor sensor;
  sensor.columns = 32;
  sensor.altitudes_deg = {-5.0, 5.0};
  sensor.azimuths_deg = {0.0, 0.0};
  return sensor;
}

/// Number of packets of a whole turn.
inline std::size_t packets_in_turn(const OusterSensor& sensor) {
  return sensor.columns / sensor.columns_per_packet;
}

/// A packet of a turn that begins at this time of the sensor, ns.
inline std::vector<std::uint8_t> packet_of_turn(const OusterSensor& sensor, std::uint16_t frame,
                                                std::size_t index, std::uint64_t begin) {
  const std::size_t first = index * sensor.columns_per_packet;
  const std::uint64_t step = kOusterTurn / sensor.columns;
  return ouster_packet(sensor, frame, first, begin + first * step, step,
                       [](std::size_t, std::size_t) {
                         return OusterReturn{static_cast<std::uint32_t>(1e3 * kOusterRange), 7};
                       });
}

}  // namespace lidar_mapping::test
