// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/velodyne_calibration.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/value.hpp"

namespace lidar_mapping::preprocessing {

namespace {

using config::Value;

/// Largest size of an entry, in m or rad or counts. Chosen: larger than any of a sensor.
constexpr double kLargest = 100'000.0;

/// Reads the entries of a map, which has to live as long.
class Entries {
 public:
  /// `what` names the map in messages.
  Entries(const Value& value, std::string what) : what_(std::move(what)) {
    map_ = std::get_if<Value::Map>(&value.data);
    if (map_ == nullptr) fail("is no map of a calibration");
  }

  /// The number; the default if the entry is missing. Without a default it has to be there.
  double number(const std::string& key, std::optional<double> otherwise = std::nullopt) const {
    const auto found = map_->find(key);
    if (found == map_->end()) {
      if (!otherwise) fail("has no entry '" + key + "'");
      return *otherwise;
    }
    const double* real = std::get_if<double>(&found->second.data);
    const int* whole = std::get_if<int>(&found->second.data);
    const double value = real != nullptr ? *real : whole != nullptr ? *whole : std::nan("");
    if (!(std::abs(value) < kLargest)) {
      fail("'" + key + "' is " + to_string(found->second) + ", which is no number of a laser");
    }
    return value;
  }

  bool flag(const std::string& key) const {
    const auto found = map_->find(key);
    if (found == map_->end()) return false;
    const bool* value = std::get_if<bool>(&found->second.data);
    if (value == nullptr) fail("'" + key + "' is neither true nor false");
    return *value;
  }

  const Value::List& list(const std::string& key) const {
    const auto found = map_->find(key);
    const auto* list =
        found == map_->end() ? nullptr : std::get_if<Value::List>(&found->second.data);
    if (list == nullptr) fail("has no list '" + key + "'");
    return *list;
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw ConfigError(what_ + " " + problem +
                      "; name a calibration file as velodyne_pointcloud has them in params");
  }

 private:
  std::string what_;
  const Value::Map* map_ = nullptr;
};

LaserCorrection correction_of(const Entries& entries) {
  LaserCorrection laser;
  laser.rot_correction = entries.number("rot_correction");
  laser.vert_correction = entries.number("vert_correction");
  laser.dist_correction = entries.number("dist_correction", 0.0);
  laser.dist_correction_x = entries.number("dist_correction_x", 0.0);
  laser.dist_correction_y = entries.number("dist_correction_y", 0.0);
  laser.has_two_points = entries.flag("two_pt_correction_available");
  laser.vert_offset_correction = entries.number("vert_offset_correction", 0.0);
  laser.horiz_offset_correction = entries.number("horiz_offset_correction", 0.0);
  laser.min_intensity = entries.number("min_intensity", 0.0);
  laser.max_intensity = entries.number("max_intensity", 255.0);
  laser.focal_distance = entries.number("focal_distance", 0.0);
  laser.focal_slope = entries.number("focal_slope", 0.0);
  return laser;
}

}  // namespace

VelodyneCalibration read_velodyne_calibration(const std::string& path) {
  const config::Source source = config::read_yaml_file(path);
  const Entries file(source.values, "the calibration " + path);
  const Value::List& lasers = file.list("lasers");
  const std::size_t count = lasers.size();
  if (count != 16 && count != 32 && count != 64) {
    file.fail("has " + std::to_string(count) + " lasers instead of 16, 32 or 64");
  }
  VelodyneCalibration calibration;
  calibration.distance_resolution =
      file.number("distance_resolution", calibration.distance_resolution);
  if (!(calibration.distance_resolution > 0.0)) file.fail("has no distance_resolution above 0");
  calibration.lasers.resize(count);
  std::vector<bool> is_given(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    const Entries laser(lasers[i], "the calibration " + path + ": entry " + std::to_string(i));
    const double id = laser.number("laser_id");
    const bool is_there = id >= 0.0 && id < static_cast<double>(count);
    const std::size_t index = is_there ? static_cast<std::size_t>(id) : 0;
    if (!is_there || is_given[index]) laser.fail("has a laser_id that cannot be");
    is_given[index] = true;
    calibration.lasers[index] = correction_of(laser);
  }
  return calibration;
}

}  // namespace lidar_mapping::preprocessing
