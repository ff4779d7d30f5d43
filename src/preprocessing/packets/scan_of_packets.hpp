// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/packet_scan.hpp"

// What the decoders of Velodyne and Hesai have in common.
namespace lidar_mapping::preprocessing {

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
