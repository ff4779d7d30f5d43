// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/run_state.hpp"

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

std::string to_text(const GeodeticDatum& datum) {
  return formatted("%.17g %.17g %.17g", datum.latitude_deg, datum.longitude_deg, datum.altitude_m);
}

std::optional<GeodeticDatum> read_datum(std::istream& text) {
  GeodeticDatum datum;
  if (!(text >> datum.latitude_deg >> datum.longitude_deg >> datum.altitude_m)) {
    return std::nullopt;
  }
  return datum;
}

}  // namespace lidar_mapping::ros_border
