// SPDX-License-Identifier: BSD-3-Clause
#include "packets/packet_decoding.hpp"

#include <cmath>

namespace lidar_mapping::preprocessing {

namespace {

/// Largest turn from block to block, counts. Chosen: no sensor turns so far, even at 20 Hz.
constexpr unsigned kLargestStep = 500;

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

std::vector<AzimuthGroup> azimuth_groups(const unsigned* azimuths, std::size_t count) {
  std::vector<AzimuthGroup> groups;
  for (std::size_t b = 0; b < count; ++b) {
    if (groups.empty() || groups.back().azimuth != azimuths[b]) {
      groups.push_back({b, b, azimuths[b], 0.0});
    }
    groups.back().end = b + 1;
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool is_last = g + 1 == groups.size();
    const unsigned step =
        is_last ? 0U : (groups[g + 1].azimuth + kTurn - groups[g].azimuth) % kTurn;
    if (step > 0U && step <= kLargestStep) groups[g].step = step;
    if (groups[g].step == 0.0 && g > 0) groups[g].step = groups[g - 1].step;
  }
  return groups;
}

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
