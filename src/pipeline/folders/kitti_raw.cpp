// SPDX-License-Identifier: BSD-3-Clause
#include "folders/kitti_raw.hpp"

#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/folder_entries.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/rotations.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;

/// Columns of a file of oxts/data, as its dataformat.txt names them.
enum Column {
  kLat = 0,
  kLon = 1,
  kAlt = 2,
  kRoll = 3,
  kPitch = 4,
  kYaw = 5,
  kVf = 8,
  kAx = 11,
  kWx = 17,
  kPosAccuracy = 23,
  kSatellites = 26,
  kColumns = 30
};

constexpr int kMinSatellites = 4;  // by geometry: three coordinates and the receiver's clock

/// Whether the numbers are a date and time between 1970 and 2200.
bool is_plausible(const std::tm& date) {
  const auto within = [](int value, int min, int max) { return value >= min && value <= max; };
  return within(date.tm_year, 1970, 2200) && within(date.tm_mon, 1, 12) &&
         within(date.tm_mday, 1, 31) && within(date.tm_hour, 0, 23) && within(date.tm_min, 0, 59) &&
         within(date.tm_sec, 0, 60);
}

Stamp date_of(const std::string& line, const fs::path& path, std::size_t number) {
  std::tm date{};
  char digits[10] = "";
  const int found =
      std::sscanf(line.c_str(), "%4d-%2d-%2d %2d:%2d:%2d.%9[0-9]", &date.tm_year, &date.tm_mon,
                  &date.tm_mday, &date.tm_hour, &date.tm_min, &date.tm_sec, digits);
  if (found < 6 || !is_plausible(date)) {
    throw FileError(path.string() + ", line " + std::to_string(number) + ": '" + line +
                    "' is no date like 2011-09-26 13:02:25.967790592");
  }
  date.tm_year -= 1900;
  date.tm_mon -= 1;
  std::string padded = digits;
  padded.resize(9, '0');
  return static_cast<Stamp>(timegm(&date)) * 1'000'000'000 + std::stoll(padded);
}

Eigen::Vector3d vector_at(const std::vector<double>& values, std::size_t first) {
  return {values[first], values[first + 1], values[first + 2]};
}

OxtsSample sample_of(const std::vector<double>& v, Stamp stamp) {
  OxtsSample sample;
  sample.fix = {stamp, v[kLat], v[kLon], v[kAlt], v[kSatellites] < kMinSatellites ? -1 : 0, {}};
  const double sigma = v[kPosAccuracy];
  if (sigma > 0.0) sample.fix.covariance = Eigen::Matrix3d::Identity() * sigma * sigma;
  sample.imu.stamp = sample.velocity.stamp = stamp;
  sample.imu.linear_acceleration = vector_at(v, kAx);
  sample.imu.angular_velocity = sample.velocity.angular = vector_at(v, kWx);
  sample.imu.orientation = rotation_from_rpy(v[kRoll], v[kPitch], v[kYaw]);
  sample.velocity.linear = vector_at(v, kVf);
  return sample;
}

double next_coordinate(std::istream& words) {
  std::string word;
  words >> word;
  return coordinate(word);
}

}  // namespace

std::vector<Stamp> read_kitti_dates(const fs::path& path) {
  std::ifstream file = open_for_reading(path);
  std::vector<Stamp> stamps;
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (!line.empty()) stamps.push_back(date_of(line, path, number));
  }
  return stamps;
}

std::vector<OxtsSample> read_oxts(const fs::path& folder) {
  const fs::path data = folder / "data";
  if (!fs::is_directory(data)) throw FileError("no folder " + data.string() + "; copy it again");
  const std::vector<Stamp> stamps = read_kitti_dates(folder / "timestamps.txt");
  const std::vector<fs::path> files =
      sorted_paths_in(data, [](const fs::directory_entry&) { return true; });
  if (files.size() > stamps.size()) {
    throw FileError((folder / "timestamps.txt").string() + " has " + std::to_string(stamps.size()) +
                    " dates for " + std::to_string(files.size()) +
                    " files in data/; copy it again");
  }
  std::vector<OxtsSample> samples;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::vector<double> values = read_numbers(files[i]);
    if (values.size() < kColumns) {
      throw FileError(files[i].string() + " has " + std::to_string(values.size()) +
                      " numbers, not " + std::to_string(kColumns) + "; copy it again");
    }
    samples.push_back(sample_of(values, stamps[i]));
  }
  return samples;
}

PointCloud read_text_scan(const fs::path& path) {
  const std::vector<double> values = read_numbers(path);
  if (values.size() % 4 != 0) {
    throw FileError(path.string() + " has " + std::to_string(values.size()) +
                    " numbers, no multiple of four; copy it again");
  }
  PointCloud cloud;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    cloud.points.push_back({static_cast<float>(values[i]), static_cast<float>(values[i + 1]),
                            static_cast<float>(values[i + 2]), static_cast<float>(values[i + 3])});
  }
  return cloud;
}

std::optional<Pose> read_imu_to_velo(const fs::path& path) try {
  if (!fs::exists(path)) return std::nullopt;
  std::ifstream file = open_for_reading(path);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  bool has_rotation = false, has_translation = false;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "R:") {
      for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = next_coordinate(words);
      has_rotation = true;
    } else if (key == "T:") {
      for (int i = 0; i < 3; ++i) matrix(i, 3) = next_coordinate(words);
      has_translation = true;
    }
  }
  if (!has_rotation || !has_translation) throw InputError("it lacks the lines 'R:' or 'T:'");
  return rigid_pose(matrix);
} catch (const InputError& error) {
  throw FileError(path.string() + ": " + error.what() + "; copy it again");
}

}  // namespace lidar_mapping::pipeline
