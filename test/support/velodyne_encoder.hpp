// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/units.hpp"

// Packets as sensors of Velodyne send them, and by formulas of its own where their points lie.
namespace lidar_mapping::test {

using VelodyneBytes = std::array<std::uint8_t, 1206>;

/// What a sensor measures: counts of the range (0 for no return) and the reflectivity.
struct VelodyneReturn {
  std::uint16_t counts = 0;
  std::uint8_t reflectivity = 0;
};

inline void put_number(VelodyneBytes& packet, std::size_t at, std::uint64_t number,
                       std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) packet[at + i] = (number >> (8 * i)) & 0xFFU;
}

/// Writes a block with the returns of its 32 channels.
inline void put_block(VelodyneBytes& packet, std::size_t block, std::uint16_t azimuth,
                      const std::function<VelodyneReturn(std::size_t channel)>& measured,
                      std::uint16_t flag = 0xEEFF) {
  const std::size_t at = 100 * block;
  put_number(packet, at, flag, 2);
  put_number(packet, at + 2, azimuth, 2);
  for (std::size_t channel = 0; channel < 32; ++channel) {
    const VelodyneReturn value = measured(channel);
    put_number(packet, at + 4 + 3 * channel, value.counts, 2);
    packet[at + 6 + 3 * channel] = value.reflectivity;
  }
}

/// Writes the sensor's time, the return mode and the product.
inline void put_end(VelodyneBytes& packet, std::uint32_t microseconds, std::uint8_t mode,
                    std::uint8_t product) {
  put_number(packet, 1200, microseconds, 4);
  packet[1204] = mode;
  packet[1205] = product;
}

constexpr std::uint8_t kStrongest = 0x37, kDual = 0x39;
constexpr std::uint8_t kIsHdl32 = 0x21, kIsVlp16 = 0x22, kIsVlp32c = 0x28;

/// Elevations of a VLP-16 by the numbers of its lasers, degrees, from its data sheet.
constexpr std::array<double, 16> kVlp16Elevations = {-15, 1, -13, 3,  -11, 5,  -9, 7,
                                                     -7,  9, -5,  11, -3,  13, -1, 15};

/// Where a laser at an elevation sees a point: azimuth clockwise from ahead, both in degrees.
inline Eigen::Vector3d seen_at(double range, double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * kRadPerDeg;
  const double elevation = elevation_deg * kRadPerDeg;
  return range * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                 -std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
}

}  // namespace lidar_mapping::test
