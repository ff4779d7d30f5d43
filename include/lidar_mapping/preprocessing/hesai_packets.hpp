// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/hesai_calibration.hpp"
#include "lidar_mapping/preprocessing/packet_scan.hpp"

namespace lidar_mapping::preprocessing {

/// A data packet of a Hesai as the sensor sends it, or the calibration that the driver puts beside
/// them, and when it came.
struct HesaiPacket {
  Stamp stamp = 0;                      ///< of the packet, ns
  const unsigned char* data = nullptr;  ///< its bytes
  std::size_t size = 0;                 ///< number of bytes
};

/// The name of the model whose packet this is by its size, as Hesai's driver has it: "PandarXT-32".
/// Empty if packets of that size are not read.
std::string hesai_model_name(const HesaiPacket& packet);

/// Decodes the packets of Pandar40P, Pandar64, PandarQT, PandarXT-16 and PandarXT-32, in single and
/// dual return mode. Formats, firing times and nominal angles are those of the user's manuals and
/// of Hesai's driver (HesaiLidar_General_ROS). Each point has its own azimuth, interpolated between
/// blocks, and its own time: that of its packet by the sensor's clock, and the firing's. Axes are
/// those of the driver: y ahead, where the azimuth is 0, x to the right, z up.
class HesaiDecoder {
 public:
  /// `calibration`: of the sensor; without it that which the driver puts beside the packets of a
  /// scan is used, and without that the nominal angles of the model.
  explicit HesaiDecoder(std::optional<HesaiCalibration> calibration = std::nullopt);

  /// The points of a scan whose times are relative to `stamp`. Damaged packets are left out. Where
  /// a laser has several returns, all are points unless they are equal. Throws InputError if no
  /// packet can be read, for a sensor that is not known, or for a calibration of another one.
  PacketScan decode(const std::vector<HesaiPacket>& packets, Stamp stamp,
                    PointCloud buffer = {}) const;

 private:
  std::optional<HesaiCalibration> calibration_;
};

}  // namespace lidar_mapping::preprocessing
