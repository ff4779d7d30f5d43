// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/lidar_model.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Beams at equal steps from `top_deg` down to `bottom_deg`.
struct Fan {
  int beams;
  double top_deg, bottom_deg;
};

LidarModel spinning(const char* name, int columns, double min_range, double max_range,
                    const std::vector<Fan>& fans) {
  LidarModel model{name, {}, columns, min_range, max_range};
  for (const auto& [beams, top_deg, bottom_deg] : fans) {
    for (int i = 0; i < beams; ++i) {
      model.elevations.push_back((top_deg + (bottom_deg - top_deg) * i / (beams - 1)) * kRadPerDeg);
    }
  }
  model.beams = static_cast<int>(model.elevations.size());
  return model;
}

const LidarModel kLidars[] = {
    // Two blocks of 32 lasers: 1/3 degree apart above, 1/2 degree below.
    spinning("hdl64", 1800, 0.9, 120.0, {{32, 2.0, -8.33}, {32, -8.83, -24.8}}),
    spinning("vlp16", 1800, 0.5, 100.0, {{16, 15.0, -15.0}}),
    spinning("os1_64", 1024, 0.5, 100.0, {{64, 22.5, -22.5}}),
    // Ouster OS0-64: a vertical field of 90 degrees and a shorter range.
    spinning("os0", 1024, 0.3, 60.0, {{64, 45.0, -45.0}}),
    // Livox Mid-360: 200,000 points a second, 4 at a time.
    {"mid360", {}, 5000, 0.1, 60.0, ScanPattern::kSwinging, 4},
    // Livox Avia: 240,000 points a second, 6 at a time.
    {"avia", {}, 4000, 1.0, 150.0, ScanPattern::kRosette, 6},
    // RoboSense M1: 750,000 points a second, 5 at a time.
    {"rs_m1", {}, 15000, 0.5, 150.0, ScanPattern::kRaster, 5}};

}  // namespace

LidarModel lidar_model(const std::string& name) {
  for (const LidarModel& model : kLidars) {
    if (model.name == name) return model;
  }
  throw ConfigError("lidar: '" + name + "' is unknown; use one of " + joined(lidar_names(), " "));
}

std::vector<std::string> lidar_names() {
  std::vector<std::string> names;
  for (const LidarModel& model : kLidars) names.push_back(model.name);
  return names;
}

double column_azimuth(const LidarModel& model, int column) {
  return kPi - 2.0 * kPi * column / model.columns;
}

Stamp column_delay(const LidarModel& model, Stamp period, int column) {
  return period * column / model.columns;
}

}  // namespace lidar_mapping::simulation
