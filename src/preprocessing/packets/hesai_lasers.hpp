// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace lidar_mapping::preprocessing {

/// Where a laser of a Hesai looks by design, and when it fires.
struct HesaiLaser {
  double elevation_deg;  ///< above the sensor's plane
  double azimuth_deg;    ///< clockwise, from above, from the azimuth of its block
  double firing_us;      ///< after the time of its block, when the sensor is at the block's azimuth
};

// The lasers of the models by their channels in a packet.
const std::vector<HesaiLaser>& pandar40p_lasers();
const std::vector<HesaiLaser>& pandar64_lasers();
const std::vector<HesaiLaser>& pandar_qt_lasers();
const std::vector<HesaiLaser>& pandar_xt16_lasers();
const std::vector<HesaiLaser>& pandar_xt32_lasers();

}  // namespace lidar_mapping::preprocessing
