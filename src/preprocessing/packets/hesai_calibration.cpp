// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/hesai_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <sstream>

#include "lidar_mapping/common/csv.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr int kMostChannels = 64;  // of a Pandar64, by its user's manual
/// Largest elevation and azimuth of a laser, degrees, by geometry: a beam looks up, down or behind.
constexpr double kLargestElevation = 90.0, kLargestAzimuth = 180.0;

const char* const kByteOrderMark = "\xEF\xBB\xBF";  // of UTF-8, which some files begin with

/// The cells of a line without the white space around them; files of Windows end lines by \r\n. A
/// comma may end a line, too.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells = csv_cells(line);
  if (cells.back().empty()) cells.pop_back();
  for (std::string& cell : cells) {
    const std::size_t begin = std::min(cell.find_first_not_of(" \t\r"), cell.size());
    cell = cell.substr(begin, cell.find_last_not_of(" \t\r") - begin + 1);
  }
  return cells;
}

/// An angle in rad. Throws InputError for one beyond `largest` degrees.
double angle(const std::string& cell, double largest) {
  const double degrees = finite_number(cell);
  if (std::abs(degrees) > largest) {
    throw InputError("an angle of " + cell + " degrees is beyond " + formatted("%g", largest));
  }
  return degrees * kRadPerDeg;
}

/// The channels of a file, line by line.
class ChannelReader {
 public:
  /// Throws InputError for a line that is wrong.
  void add(const std::string& line) {
    const std::vector<std::string> cells = cells_of(line);
    const bool is_empty = std::all_of(cells.begin(), cells.end(),
                                      [](const std::string& cell) { return cell.empty(); });
    if (is_empty || is_names(cells)) return;
    if (cells.size() != 3) {
      throw InputError(std::to_string(cells.size()) + " values instead of 3");
    }
    const auto channel = static_cast<int>(whole_number(cells[0], 1, kMostChannels));
    const HesaiLaserAngles angles = {angle(cells[1], kLargestElevation),
                                     angle(cells[2], kLargestAzimuth)};
    if (!channels_.emplace(channel, angles).second) {
      throw InputError("channel " + cells[0] + " is there twice");
    }
  }

  /// Throws InputError if channels are missing.
  HesaiCalibration calibration() const {
    const std::size_t count = channels_.size();
    if (count != 16 && count != 32 && count != 40 && count != 64) {
      throw InputError(std::to_string(count) + " channels instead of 16, 32, 40 or 64");
    }
    const int last = channels_.rbegin()->first;
    if (last != static_cast<int>(count)) {
      throw InputError(std::to_string(count) + " channels, but the last one is " +
                       std::to_string(last));
    }
    HesaiCalibration calibration;
    for (const auto& [channel, angles] : channels_) calibration.lasers.push_back(angles);
    return calibration;
  }

 private:
  /// Whether a line has the names of the columns, which it has above the first channel.
  bool is_names(const std::vector<std::string>& cells) const {
    return channels_.empty() && cells.size() > 1 && lower_case(cells[1]) == "elevation";
  }

  std::map<int, HesaiLaserAngles> channels_;
};

[[noreturn]] void fail(const std::string& place, const std::string& problem) {
  throw ConfigError("the calibration " + place + ": " + problem +
                    "; name a file of lines 'channel,elevation,azimuth' (degrees) as Hesai's "
                    "driver has them in config");
}

}  // namespace

HesaiCalibration parse_hesai_calibration(const std::string& content, const std::string& name) {
  std::istringstream lines(content);
  ChannelReader channels;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (number == 1 && line.rfind(kByteOrderMark, 0) == 0) line.erase(0, 3);
    try {
      channels.add(line);
    } catch (const InputError& error) {
      fail(name + ", line " + std::to_string(number), error.what());
    }
  }
  try {
    return channels.calibration();
  } catch (const InputError& error) {
    fail(name, error.what());
  }
}

HesaiCalibration read_hesai_calibration(const std::string& path) {
  std::ifstream file = open_for_reading(path);
  return parse_hesai_calibration({std::istreambuf_iterator<char>(file), {}}, path);
}

}  // namespace lidar_mapping::preprocessing
