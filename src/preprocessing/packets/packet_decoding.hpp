// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/packet_scan.hpp"

// What the decoders of Velodyne and Hesai have in common.
namespace lidar_mapping::preprocessing {

/// Counts of azimuth in a turn: 0.01 degrees each, by the user's manual of Velodyne and of Hesai.
constexpr unsigned kTurn = 36000;

/// The blocks of a packet that were measured at the same azimuth: of several banks of lasers, and
/// all returns where a laser has more than one.
struct AzimuthGroup {
  std::size_t begin = 0;  ///< first block
  std::size_t end = 0;    ///< after the last block
  unsigned azimuth = 0;   ///< counts
  double step = 0.0;      ///< counts to the next group; the last group has that of the one before
};

/// The groups of a packet with these azimuths of its `count` blocks, counts.
std::vector<AzimuthGroup> azimuth_groups(const unsigned* azimuths, std::size_t count);

/// When a packet came, and when it was made.
struct PacketTime {
  Stamp stamp = 0;                ///< when it came, ns
  std::int64_t microseconds = 0;  ///< by the sensor's clock, us since that began anew
};

/// Times of packets, s after the scan's stamp. They are those of the sensor's clock, which no
/// network delays; the packet that came soonest says how that clock stands to the stamps. Without
/// such a clock the times are the stamps. `period`: us after which the sensor's clock begins anew.
std::vector<double> packet_times(const std::vector<PacketTime>& packets, std::int64_t period,
                                 Stamp stamp);

/// Takes the packets that are not whole out of those of a scan, and returns the scan without its
/// points. The memory of `buffer` is used again. Throws InputError if all packets are damaged.
template <typename Packet, typename IsWhole>
PacketScan scan_of_whole(std::vector<Packet>& packets, const IsWhole& is_whole,
                         const std::string& maker, const std::string& model, PointCloud buffer) {
  const std::string count = std::to_string(packets.size());
  const auto damaged = std::stable_partition(packets.begin(), packets.end(), is_whole);
  PacketScan scan;
  scan.damaged_packets = static_cast<std::size_t>(packets.end() - damaged);
  scan.contents = count + " packets of a " + maker + " " + model;
  packets.erase(damaged, packets.end());
  if (packets.empty()) {
    throw InputError("all " + count + " packets of a " + maker + " scan are damaged");
  }
  scan.cloud = std::move(buffer);
  scan.cloud.points.clear();
  scan.cloud.times.clear();
  return scan;
}

/// Throws InputError if a calibration with so many lasers is that of another sensor than `model`.
/// `name` is where it is from.
inline void check_lasers(const std::string& name, std::size_t calibrated, const std::string& model,
                         std::size_t lasers) {
  if (calibrated == lasers) return;
  throw InputError(name + " is of " + std::to_string(calibrated) +
                   " lasers, but the packets are those of a " + model + " with " +
                   std::to_string(lasers) + "; name the file of this sensor");
}

}  // namespace lidar_mapping::preprocessing
