// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

namespace lidar_mapping::simulation {

namespace {

/// The golden ratio less 1, by geometry: its multiples are spread best over [0, 1).
constexpr double kGolden = 0.618033988749895;

// Mid-360: ten turns per frame. Each turn is shifted against the previous one by a fraction of a
// column and a fraction of a quarter of the swing, both golden, so that turns and frames fill the
// gaps of the previous ones. Field of view by the data sheet; turns and swings are chosen after the
// published description.
constexpr double kColumnsPerTurn = 500.0 + kGolden;
constexpr double kSwingsPerTurn = 17.0 + 0.25 * kGolden;
constexpr double kSwingLow = -7.0 * kRadPerDeg, kSwingHigh = 52.0 * kRadPerDeg;

// Avia: turns of its two prisms per frame of 0.1 s (7294 and 4664 a minute, in opposite
// directions), the largest deflection by both together, and the fan of its beams: field of view and
// rates by the manufacturer's manual.
constexpr double kFirstPrism = 12.15667, kSecondPrism = 7.77333;
constexpr double kDeflection = 35.2 * kRadPerDeg;
constexpr double kFan = 6.8 * kRadPerDeg;

// M1: five fields side by side, each of 120 x 125 points at 0.2 degrees: field of view (120 x 25
// degrees) and resolution by the data sheet.
constexpr int kRasterColumns = 120, kRasterRows = 125;
constexpr double kRasterStep = 0.2 * kRadPerDeg;

double fraction(double x) { return x - std::floor(x); }

struct Angle {
  explicit Angle(double radians) : cosine(std::cos(radians)), sine(std::sin(radians)) {}

  double cosine, sine;
};

Eigen::Vector3d direction(const Angle& azimuth, const Angle& elevation) {
  return {elevation.cosine * azimuth.cosine, elevation.cosine * azimuth.sine, elevation.sine};
}

Eigen::Vector3d direction(double azimuth, double elevation) {
  return direction(Angle(azimuth), Angle(elevation));
}

/// `column` counts from the first frame of the drive.
Eigen::Vector3d swinging(const LidarModel& model, double column, int beam) {
  const double turns = column / kColumnsPerTurn;
  const double phase = fraction(turns * kSwingsPerTurn +
                                static_cast<double>(beam) / static_cast<double>(model.beams));
  const double up = 1.0 - std::abs(2.0 * phase - 1.0);
  return direction(kPi - 2.0 * kPi * fraction(turns), kSwingLow + up * (kSwingHigh - kSwingLow));
}

Eigen::Vector3d rosette(const LidarModel& model, double column, int beam) {
  const double frames = column / model.columns;
  const double first = 2.0 * kPi * fraction(frames * kFirstPrism);
  const double second = -2.0 * kPi * fraction(frames * kSecondPrism);
  const double fan = kFan * (0.5 - beam / (model.beams - 1.0));
  const double left = 0.5 * kDeflection * (std::cos(first) + std::cos(second));
  const double up = 0.5 * kDeflection * (std::sin(first) + std::sin(second)) + fan;
  const double off_axis = std::hypot(left, up);
  const double scale = off_axis > 0.0 ? std::sin(off_axis) / off_axis : 1.0;
  return {std::cos(off_axis), scale * left, scale * up};
}

/// Row by row from the top, alternately in both directions.
Eigen::Vector3d raster(const LidarModel& model, int column, int beam) {
  const int row = column / kRasterColumns, step = column % kRasterColumns;
  const int position = row % 2 == 0 ? step : kRasterColumns - 1 - step;
  const double from_left = beam * kRasterColumns + position + 0.5;
  return direction((0.5 * model.beams * kRasterColumns - from_left) * kRasterStep,
                   (0.5 * kRasterRows - row - 0.5) * kRasterStep);
}

Eigen::Vector3d ray_direction(const LidarModel& model, std::size_t frame, int column, int beam) {
  const double since_start = static_cast<double>(frame) * model.columns + column;
  if (model.pattern == ScanPattern::kSwinging) return swinging(model, since_start, beam);
  if (model.pattern == ScanPattern::kRosette) return rosette(model, since_start, beam);
  return raster(model, column, beam);
}

std::vector<Eigen::Vector3d> spinning_directions(const LidarModel& model) {
  std::vector<Angle> elevations(model.elevations.begin(), model.elevations.end());
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(model.ray_count());
  for (int column = 0; column < model.columns; ++column) {
    const Angle azimuth(column_azimuth(model, column));
    for (const Angle& elevation : elevations) directions.push_back(direction(azimuth, elevation));
  }
  return directions;
}

}  // namespace

std::vector<Eigen::Vector3d> ray_directions(const LidarModel& model, std::size_t frame) {
  if (model.pattern == ScanPattern::kSpinning) return spinning_directions(model);
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(model.ray_count());
  for (int column = 0; column < model.columns; ++column) {
    for (int beam = 0; beam < model.beams; ++beam) {
      directions.push_back(ray_direction(model, frame, column, beam));
    }
  }
  return directions;
}

}  // namespace lidar_mapping::simulation
