// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar_mapping/preprocessing/hesai_calibration.hpp"
#include "lidar_mapping/preprocessing/hesai_packets.hpp"

namespace lidar_mapping::preprocessing {

/// Until the time of the sensor begins anew, us, by the user's manual: a second.
constexpr std::int64_t kHesaiSecond = 1'000'000;

/// Where a laser of a Hesai looks by design, and when it fires.
struct HesaiLaser {
  double elevation_deg;  ///< above the sensor's plane
  double azimuth_deg;    ///< clockwise, from above, from the azimuth of its block
  double firing_us;      ///< after the time of its block, when the sensor is at the block's azimuth
};

/// What distinguishes the models of Hesai: the layout of their packets, and when their blocks are
/// measured.
struct HesaiModel {
  const char* name;        ///< of the driver
  std::size_t bytes;       ///< of a packet, without the number that may follow
  std::size_t header;      ///< bytes before the first block; 0: blocks begin with a flag instead
  std::size_t lasers_at;   ///< byte of the number of lasers in the header
  std::size_t blocks;      ///< of a packet
  std::size_t block;       ///< bytes of a block
  std::size_t azimuth;     ///< byte of the azimuth in a block, behind which are the measurements
  std::size_t channel;     ///< bytes of a measurement: range (two), reflectivity and others
  std::size_t time;        ///< byte of the time in a packet
  double block_us;         ///< from one azimuth to the next
  double offset_us;        ///< from the packet's time to that of its first or last azimuth
  bool counts_from_first;  ///< whether the offset is that of the first azimuth
  std::vector<HesaiLaser> lasers;  ///< by their channels

  /// Block `index` of a packet.
  const unsigned char* block_of(const HesaiPacket& packet, std::size_t index) const {
    return packet.data + header + index * block;
  }
  /// Azimuth of a block, counts of 0.01 degrees.
  unsigned azimuth_of(const unsigned char* at) const;
  /// Measurement of a laser in a block.
  const unsigned char* channel_of(const unsigned char* at, std::size_t laser) const {
    return at + azimuth + 2 + laser * channel;
  }
  /// m of a count of the ranges in a packet.
  double distance_resolution(const HesaiPacket& packet) const;
  /// us of the second by the sensor's clock.
  std::int64_t microseconds_of(const HesaiPacket& packet) const;
  /// Whether a packet is one of this model.
  bool is_whole(const HesaiPacket& packet) const;
};

/// The model whose packets have this size; null if there is none.
const HesaiModel* hesai_model_of_size(std::size_t size);

/// The model of most packets, as one may be damaged. Throws InputError if it is not known.
const HesaiModel& hesai_model(const std::vector<HesaiPacket>& packets);

/// The directions of a model's lasers by design.
HesaiCalibration nominal_calibration(const HesaiModel& model);

}  // namespace lidar_mapping::preprocessing
