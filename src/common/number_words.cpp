// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/number_words.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"

namespace lidar_mapping {

namespace {

// Largest error of the products of axes of a rotation. Chosen: files with three digits have 0.003.
constexpr double kMaxRotationError = 0.05;
constexpr std::size_t kShown = 40;  // characters of a word in a message; chosen: half a line

/// A word in a message, without its end if it is long.
std::string shown(const std::string& word) {
  return "'" + word.substr(0, kShown) + (word.size() > kShown ? "..." : "") + "'";
}

}  // namespace

double finite_number(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || end != word.c_str() + word.size() || !std::isfinite(value)) {
    throw InputError(shown(word) + " is no finite number");
  }
  return value;
}

double coordinate(const std::string& word) {
  const double value = finite_number(word);
  if (std::abs(value) > kMaxCoordinate) throw InputError(shown(word) + " m is no place on Earth");
  return value;
}

std::int64_t whole_number(const std::string& word, std::int64_t least, std::int64_t most) {
  std::int64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end || value < least || value > most) {
    throw InputError(shown(word) + " is no whole number from " + std::to_string(least) + " to " +
                     std::to_string(most));
  }
  return value;
}

Stamp stamp_of_nanoseconds(const std::string& word) {
  constexpr Stamp kMost = from_seconds(kMaxTime);
  return whole_number(word, -kMost, kMost);
}

Stamp stamp_of_seconds(double seconds) {
  if (!(std::abs(seconds) < kMaxTime)) {
    throw InputError(std::to_string(seconds) + " s is no time; wanted seconds since 1970");
  }
  return from_seconds(seconds);
}

Stamp stamp_of_seconds(const std::string& word) {
  const Stamp rounded = stamp_of_seconds(finite_number(word));
  if (word.find_first_not_of("0123456789.") != std::string::npos) return rounded;
  const std::size_t point = word.find('.');
  std::string fraction = point == std::string::npos ? "" : word.substr(point + 1);
  fraction.resize(9, '0');
  const std::string whole = word.substr(0, point);
  return (whole.empty() ? 0 : std::stoll(whole)) * kNanosecondsPerSecond + std::stoll(fraction);
}

Pose rigid_pose(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d axes = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d products = axes.transpose() * axes;
  const double off = (products - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  // maxCoeff() may overlook NaN.
  if (!matrix.topRows<3>().allFinite() || !(off < kMaxRotationError) || axes.determinant() < 0.0) {
    throw InputError("the matrix holds no rotation");
  }
  return Pose::from_matrix(matrix);
}

std::vector<double> read_numbers(const std::filesystem::path& path) {
  std::ifstream file = open_for_reading(path);
  std::vector<double> values;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      try {
        values.push_back(finite_number(word));
      } catch (const InputError& error) {
        throw FileError(path.string() + ":" + std::to_string(number) + ": " + error.what());
      }
    }
  }
  return values;
}

}  // namespace lidar_mapping
