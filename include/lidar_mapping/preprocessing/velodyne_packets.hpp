// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/packet_scan.hpp"
#include "lidar_mapping/preprocessing/velodyne_calibration.hpp"

namespace lidar_mapping::preprocessing {

/// A data packet of a Velodyne as the sensor sends it, and when it came.
struct VelodynePacket {
  /// Bytes of a packet: 12 blocks of 100 bytes, a time and two bytes by the user's manual.
  static constexpr std::size_t kBytes = 1206;

  Stamp stamp = 0;                      ///< of the packet, ns
  const unsigned char* data = nullptr;  ///< kBytes of them
};

/// Decodes the packets of VLP-16, Puck Hi-Res, VLP-32C, HDL-32E and HDL-64E (S2, S3), in single and
/// dual return mode. Formats, firing times and nominal angles are those of the user's manuals
/// (63-9243 VLP-16, 63-9325 VLP-32C, 63-9113 HDL-32E, 63-HDL64E S2 and S3). Each point has its own
/// azimuth, interpolated between blocks, and its own time: that of its packet by the sensor's
/// clock, plus the firing's. Points of an HDL-64E, whose manual has no firing times, have those of
/// their block.
class VelodyneDecoder {
 public:
  /// `calibration`: of the sensor; without it the nominal angles of the model are used, which an
  /// HDL-64E does not have.
  explicit VelodyneDecoder(std::optional<VelodyneCalibration> calibration = std::nullopt);

  /// The points of a scan whose times are relative to `stamp`. Damaged packets are left out. Where
  /// a laser has two returns, both are points unless they are equal. Throws InputError if no packet
  /// can be read, or for a sensor whose lasers are not known.
  PacketScan decode(const std::vector<VelodynePacket>& packets, Stamp stamp,
                    PointCloud buffer = {}) const;

 private:
  std::optional<VelodyneCalibration> calibration_;
};

}  // namespace lidar_mapping::preprocessing
