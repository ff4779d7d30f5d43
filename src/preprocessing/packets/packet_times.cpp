// SPDX-License-Identifier: BSD-3-Clause
#include "packets/packet_times.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::preprocessing {

namespace {

/// Largest difference of the sensor's clock from the stamps within a scan, s. Chosen: stamps of
/// packets that wait in a network are late by less; a sensor without a clock differs by more.
constexpr double kSameClock = 0.05;

/// Seconds from the first packet to each one by the sensor's clock; empty if that is no clock.
std::vector<double> sensor_times(const std::vector<PacketTime>& packets, std::int64_t period) {
  std::vector<double> times;
  for (const PacketTime& packet : packets) {
    std::int64_t passed = packet.microseconds - packets.front().microseconds;
    if (passed < -period / 2) passed += period;
    times.push_back(1e-6 * static_cast<double>(passed));
    const double by_stamps = to_seconds(packet.stamp - packets.front().stamp);
    if (std::abs(times.back() - by_stamps) > kSameClock) return {};
  }
  return times;
}

}  // namespace

std::vector<double> packet_times(const std::vector<PacketTime>& packets, std::int64_t period,
                                 Stamp stamp) {
  const std::vector<double> sensor = sensor_times(packets, period);
  double soonest = 0.0;
  for (std::size_t i = 0; i < sensor.size(); ++i) {
    const double offset = to_seconds(packets[i].stamp - stamp) - sensor[i];
    soonest = i == 0 ? offset : std::min(soonest, offset);
  }
  std::vector<double> times;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    times.push_back(sensor.empty() ? to_seconds(packets[i].stamp - stamp) : sensor[i] + soonest);
  }
  return times;
}

}  // namespace lidar_mapping::preprocessing
