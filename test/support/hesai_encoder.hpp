// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/units.hpp"

// Packets as sensors of Hesai send them, written field after field as the user's manuals list them,
// and by formulas of its own where their points lie.
namespace lidar_mapping::test {

using HesaiBytes = std::vector<std::uint8_t>;

/// What a sensor measures: counts of the range (4 mm, 0 for no return) and the reflectivity.
struct HesaiReturn {
  std::uint16_t counts = 0;
  std::uint8_t reflectivity = 0;
};

/// What a model writes.
struct HesaiSensor {
  std::uint8_t lasers;
  std::uint8_t blocks;
  std::uint8_t protocol;  ///< 0: the packets have no numbers of the protocol
  bool has_confidence;    ///< behind each reflectivity
};
constexpr HesaiSensor kPandar40p{40, 10, 0, false}, kPandar64{64, 6, 0, false},
    kPandarQt{64, 4, 3, true}, kPandarXt16{16, 8, 6, true}, kPandarXt32{32, 8, 6, true};

/// A block of a packet: its azimuth (counts of 0.01 degrees) and what the lasers measured.
struct HesaiBlock {
  std::uint16_t azimuth = 0;
  std::function<HesaiReturn(std::size_t laser)> measured;
};

class HesaiPacketWriter {
 public:
  explicit HesaiPacketWriter(const HesaiSensor& sensor) : sensor_(sensor) {}

  /// `number`: whether the packet's number follows, as users can choose for some models.
  HesaiBytes write(const std::vector<HesaiBlock>& blocks, std::uint32_t microseconds,
                   bool number = true) {
    put_header();
    for (const HesaiBlock& block : blocks) put_block(block);
    put_tail(microseconds);
    if (number) put(4711, 4);
    return bytes_;
  }

 private:
  bool has_blocks_with_flag() const { return sensor_.lasers == 40; }
  bool is_xt() const { return sensor_.protocol == 6; }

  void put(std::uint64_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) bytes_.push_back((value >> (8 * i)) & 0xFFU);
  }
  void put_all(const std::vector<std::uint8_t>& bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void put_header() {
    if (has_blocks_with_flag()) return;
    put_all({0xEE, 0xFF});
    if (sensor_.protocol > 0) put_all({sensor_.protocol, 1, 0, 0});
    put_all({sensor_.lasers, sensor_.blocks, 0, 4});  // the unit is 4 mm
    put_all({2, 1});                                  // returns and number, or reserved
  }
  void put_block(const HesaiBlock& block) {
    if (has_blocks_with_flag()) put_all({0xFF, 0xEE});
    put(block.azimuth, 2);
    for (std::size_t laser = 0; laser < sensor_.lasers; ++laser) {
      const HesaiReturn value = block.measured(laser);
      put(value.counts, 2);
      put(value.reflectivity, 1);
      if (sensor_.has_confidence) put(0xFF, 1);
    }
  }
  void put_tail(std::uint32_t microseconds) {
    const std::vector<std::uint8_t> date = {24, 5, 17, 10, 30, 59};
    put_all(std::vector<std::uint8_t>(sensor_.protocol > 0 ? 10 : 8, 0));  // reserved
    if (is_xt()) {
      put(0x39, 1);  // return mode
      put(600, 2);   // turns a minute
      put_all(date);
      put(microseconds, 4);
      put(0x42, 1);  // of the maker
      return;
    }
    put(600, 2);
    put(microseconds, 4);
    put_all({0x39, 0x42});
    put_all(date);
  }

  HesaiSensor sensor_;
  HesaiBytes bytes_;
};

/// What HesaiLidar_General_ROS puts beside the packets of a scan: its calibration.
inline HesaiBytes hesai_calibration_packet(const std::string& text) {
  HesaiBytes bytes = {0x47, 0x74, 5, 0};
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(text.size() >> static_cast<unsigned>(shift)));
  }
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

/// Where a laser at an elevation sees a point: azimuth clockwise from y, both in degrees.
inline Eigen::Vector3d hesai_seen_at(double range, double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * kRadPerDeg;
  const double elevation = elevation_deg * kRadPerDeg;
  return range * Eigen::Vector3d(std::cos(elevation) * std::sin(azimuth),
                                 std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
}

}  // namespace lidar_mapping::test
