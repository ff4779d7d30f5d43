// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/lidar_model.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Adds `count` beams at equal steps from `top_deg` down to `bottom_deg`.
void add_beams(LidarModel& model, int count, double top_deg, double bottom_deg) {
  for (int i = 0; i < count; ++i) {
    model.elevations.push_back((top_deg + (bottom_deg - top_deg) * i / (count - 1)) * kRadPerDeg);
  }
  model.beams = static_cast<int>(model.elevations.size());
}

/// Two blocks of 32 lasers: 1/3 degree apart above, 1/2 degree below.
LidarModel hdl64() {
  LidarModel model{"hdl64", {}, 1800, 0.9, 120.0};
  add_beams(model, 32, 2.0, -8.33);
  add_beams(model, 32, -8.83, -24.8);
  return model;
}

LidarModel vlp16() {
  LidarModel model{"vlp16", {}, 1800, 0.5, 100.0};
  add_beams(model, 16, 15.0, -15.0);
  return model;
}

LidarModel os1_64() {
  LidarModel model{"os1_64", {}, 1024, 0.5, 100.0};
  add_beams(model, 64, 22.5, -22.5);
  return model;
}

/// Ouster OS0-64: a vertical field of 90 degrees and a shorter range.
LidarModel os0() {
  LidarModel model{"os0", {}, 1024, 0.3, 60.0};
  add_beams(model, 64, 45.0, -45.0);
  return model;
}

/// Livox Mid-360: 200,000 points a second, 4 at a time.
LidarModel mid360() { return {"mid360", {}, 5000, 0.1, 60.0, ScanPattern::kSwinging, 4}; }

/// Livox Avia: 240,000 points a second, 6 at a time.
LidarModel avia() { return {"avia", {}, 4000, 1.0, 150.0, ScanPattern::kRosette, 6}; }

/// RoboSense M1: 750,000 points a second, 5 at a time.
LidarModel rs_m1() { return {"rs_m1", {}, 15000, 0.5, 150.0, ScanPattern::kRaster, 5}; }

constexpr LidarModel (*kLidars[])() = {hdl64, vlp16, os1_64, os0, mid360, avia, rs_m1};

}  // namespace

LidarModel lidar_model(const std::string& name) {
  for (const auto make : kLidars) {
    LidarModel model = make();
    if (model.name == name) return model;
  }
  throw ConfigError("lidar: '" + name + "' is unknown; use one of " + joined(lidar_names(), " "));
}

std::vector<std::string> lidar_names() {
  std::vector<std::string> names;
  for (const auto make : kLidars) names.push_back(make().name);
  return names;
}

double column_azimuth(const LidarModel& model, int column) {
  return kPi - 2.0 * kPi * column / model.columns;
}

Stamp column_delay(const LidarModel& model, Stamp period, int column) {
  return period * column / model.columns;
}

}  // namespace lidar_mapping::simulation
