// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping::preprocessing {

/// Where a laser of a Hesai looks.
struct HesaiLaserAngles {
  double elevation = 0.0;  ///< rad; above the sensor's plane
  double azimuth = 0.0;    ///< rad; clockwise, from above, from the azimuth of its block
};

/// Of all lasers of a sensor.
struct HesaiCalibration {
  std::vector<HesaiLaserAngles> lasers;  ///< by their channels in a packet
};

/// Reads a calibration file of Hesai's driver (CSV: channel from 1 on, elevation and azimuth in
/// degrees, with one line of names above; 16, 32, 40 or 64 channels in any order). Throws FileError
/// if it cannot be read, and ConfigError naming file and line of what is wrong.
HesaiCalibration read_hesai_calibration(const std::string& path);

/// The same from the content of such a file; `name` stands for the file in messages. Throws
/// ConfigError as read_hesai_calibration() does.
HesaiCalibration parse_hesai_calibration(const std::string& content, const std::string& name);

}  // namespace lidar_mapping::preprocessing
