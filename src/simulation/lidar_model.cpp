#include "lidar_mapping/simulation/lidar_model.hpp"

#include <cmath>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kDegree = M_PI / 180.0;

/// `count` beams at equal steps from `top_deg` down to `bottom_deg`.
void add_beams(std::vector<double>& elevations, int count, double top_deg, double bottom_deg) {
  for (int i = 0; i < count; ++i) {
    elevations.push_back((top_deg + (bottom_deg - top_deg) * i / (count - 1)) * kDegree);
  }
}

/// Two blocks of 32 lasers: 1/3 degree apart above, 1/2 degree below.
LidarModel hdl64() {
  LidarModel model{"hdl64", {}, 1800, 0.9, 120.0};
  add_beams(model.elevations, 32, 2.0, -8.33);
  add_beams(model.elevations, 32, -8.83, -24.8);
  return model;
}

LidarModel vlp16() {
  LidarModel model{"vlp16", {}, 1800, 0.5, 100.0};
  add_beams(model.elevations, 16, 15.0, -15.0);
  return model;
}

LidarModel os1_64() {
  LidarModel model{"os1_64", {}, 1024, 0.5, 100.0};
  add_beams(model.elevations, 64, 22.5, -22.5);
  return model;
}

}  // namespace

LidarModel lidar_model(const std::string& name) {
  if (name == "hdl64") return hdl64();
  if (name == "vlp16") return vlp16();
  if (name == "os1_64") return os1_64();
  throw ConfigError("lidar: '" + name + "' is unknown; use hdl64, vlp16 or os1_64");
}

std::vector<std::string> lidar_names() { return {"hdl64", "vlp16", "os1_64"}; }

double column_azimuth(const LidarModel& model, int column) {
  return M_PI - 2.0 * M_PI * column / model.columns;
}

}  // namespace lidar_mapping::simulation
