// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/kitti_folder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr double kDefaultPeriod = 0.1;  // s, if there is no times.txt; chosen as of most LiDARs

/// Reads all elements of a file of plain little-endian values.
template <typename T>
std::vector<T> read_array(const fs::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw FileError("cannot read " + path.string() + "; is it there?");
  const auto bytes = static_cast<std::size_t>(file.tellg());
  if (bytes % sizeof(T) != 0) {
    throw FileError(path.string() + " has " + std::to_string(bytes) + " bytes, no multiple of " +
                    std::to_string(sizeof(T)) + "; copy it again");
  }
  std::vector<T> values(bytes / sizeof(T));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(bytes));
  if (!file) throw FileError("cannot read all of " + path.string());
  return values;
}

std::vector<std::string> scan_names(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw FileError("no folder " + folder.string() +
                    "; name the folder above it, that of one drive");
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".bin") names.push_back(entry.path().stem().string());
  }
  if (names.empty()) throw FileError("no .bin files in " + folder.string());
  std::sort(names.begin(), names.end(), in_order_of_numbers);
  return names;
}

std::vector<Stamp> read_stamps(const fs::path& path, std::size_t count) {
  std::vector<Stamp> stamps;
  if (!fs::exists(path)) {
    for (std::size_t i = 0; i < count; ++i) {
      stamps.push_back(from_seconds(kDefaultPeriod * static_cast<double>(i)));
    }
    return stamps;
  }
  stamps = read_times(path);
  if (stamps.size() < count) {
    throw FileError(path.string() + " has " + std::to_string(stamps.size()) + " times for " +
                    std::to_string(count) + " scans");
  }
  return stamps;
}

float time_from_azimuth(const Point& point) {
  const double turns = -std::atan2(point.y, point.x) / (2.0 * kPi);
  return static_cast<float>(turns * kKittiTurn);
}

}  // namespace

std::vector<Stamp> read_times(const fs::path& path) {
  std::vector<Stamp> stamps;
  for (const double seconds : read_numbers(path)) {
    try {
      stamps.push_back(stamp_of_seconds(seconds));
    } catch (const InputError& error) {
      throw FileError(path.string() + ", time " + std::to_string(stamps.size() + 1) + ": " +
                      error.what());
    }
  }
  return stamps;
}

std::vector<Point> read_points(const std::string& path) { return read_array<Point>(path); }

KittiFolder::KittiFolder(const std::string& path, const KittiReadOptions& options)
    : path_(path),
      options_(options),
      scans_(scan_names(fs::path(path) / "velodyne")),
      stamps_(read_stamps(fs::path(path) / "times.txt", scans_.size())) {}

Scan KittiFolder::scan(std::size_t index) const {
  const std::string& name = scans_[index];
  Scan scan;
  scan.stamp = stamps_[index];
  PointCloud& cloud = scan.cloud;
  cloud.points = read_points(fs::path(path_) / "velodyne" / (name + ".bin"));
  const fs::path times = fs::path(path_) / "point_times" / (name + ".f32");
  if (options_.time_from_azimuth) {
    for (const Point& point : cloud.points) cloud.times.push_back(time_from_azimuth(point));
  } else if (fs::exists(times)) {
    cloud.times = read_array<float>(times);
    if (cloud.times.size() != cloud.size()) {
      throw FileError(times.string() + " has " + std::to_string(cloud.times.size()) +
                      " times for " + std::to_string(cloud.size()) + " points");
    }
  }
  rotate_upwards(cloud, options_.elevation_correction);
  return scan;
}

}  // namespace lidar_mapping::pipeline
