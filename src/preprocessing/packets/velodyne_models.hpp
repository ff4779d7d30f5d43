// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/preprocessing/velodyne_calibration.hpp"
#include "lidar_mapping/preprocessing/velodyne_packets.hpp"

namespace lidar_mapping::preprocessing {

/// What distinguishes the models of Velodyne.
struct VelodyneModel {
  const char* name;       ///< of the maker
  std::size_t lasers;     ///< of the sensor
  std::size_t sequences;  ///< firing sequences of all lasers in a block (two blocks of an HDL-64E)
  double sequence;        ///< s from one sequence to the next; 0 if it is not known
  double firing;          ///< s from one firing to the next
  std::size_t together;   ///< lasers that fire at the same time
  double distance_resolution;  ///< m of a count of the range
};

/// The model that sent the packets: by the flags of their blocks and the product number at their
/// end, else by the calibration. Throws InputError if it is not known or not read.
const VelodyneModel& velodyne_model(const std::vector<VelodynePacket>& packets,
                                    const std::optional<VelodyneCalibration>& calibration);

/// The nominal directions of a model's lasers. Throws InputError for an HDL-64E, each of which has
/// its own.
VelodyneCalibration nominal_calibration(const VelodyneModel& model);

constexpr std::size_t kBlockBytes = 100;     // bytes of a block, by the user's manual
constexpr std::size_t kBlocksOfPacket = 12;  // of a packet, by the user's manual
// The flags of a block: all lasers or the upper 32, and the lower 32 of an HDL-64E.
constexpr unsigned kUpperBlock = 0xEEFF;  // little-endian, by the user's manual
constexpr unsigned kLowerBlock = 0xDDFF;  // little-endian, by the user's manual of the HDL-64E

}  // namespace lidar_mapping::preprocessing
