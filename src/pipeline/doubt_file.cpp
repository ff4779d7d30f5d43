// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"

namespace lidar_mapping::pipeline {

namespace {

constexpr const char* kHead =
    "kind,begin_s,end_s,begin_ns,end_ns,scans,way_begin_m,way_m,way_of_drive_m,x,y,z,"
    "expected_error_m,lowest_probability,trusted";

constexpr std::size_t kColumns = 15;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// A standard deviation; infinite where nobody knows.
double error_in(const std::string& cell) {
  if (cell == "inf") return std::numeric_limits<double>::infinity();
  const double error = coordinate(cell);
  if (error < 0.0) throw InputError("an error is not negative");
  return error;
}

/// Throws InputError.
DoubtfulStretch stretch_of(const std::vector<std::string>& cells) {
  if (cells.size() != kColumns) {
    throw InputError(std::to_string(cells.size()) + " cells instead of " +
                     std::to_string(kColumns));
  }
  const auto doubt = doubt_of_state(cells[0]);
  if (!doubt) throw InputError("there is no such kind of doubt");
  constexpr std::int64_t kMostScans = 1'000'000'000;
  DoubtfulStretch stretch;
  stretch.doubt = *doubt;
  stretch.begin = stamp_of_nanoseconds(cells[3]);
  stretch.end = stamp_of_nanoseconds(cells[4]);
  stretch.scans = static_cast<std::size_t>(whole_number(cells[5], 0, kMostScans));
  stretch.way_begin = coordinate(cells[6]);
  stretch.way = coordinate(cells[7]);
  stretch.place = {coordinate(cells[9]), coordinate(cells[10]), coordinate(cells[11])};
  stretch.expected_error = error_in(cells[12]);
  stretch.lowest_probability = coordinate(cells[13]);
  stretch.is_trusted = cells[14] == "yes";
  return stretch;
}

}  // namespace

void write_doubt(const DriveDoubt& doubt, const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << kHead << '\n';
  for (const DoubtfulStretch& s : doubt.stretches) {
    text << to_string(s.doubt) << ',' << to_seconds(s.begin - doubt.begin) << ','
         << to_seconds(s.end - doubt.begin) << ',' << s.begin << ',' << s.end << ',' << s.scans
         << ',' << s.way_begin << ',' << s.way << ',' << doubt.way << ',' << s.place.x() << ','
         << s.place.y() << ',' << s.place.z() << ',' << s.expected_error << ','
         << s.lowest_probability << ',' << (s.is_trusted ? "yes" : "no") << '\n';
  }
  write_text_atomically(path, text.str());
}

DriveDoubt read_doubt(const std::filesystem::path& path) {
  std::ifstream file = open_for_reading(path);
  DriveDoubt doubt;
  std::string line;
  std::getline(file, line);
  for (int number = 2; std::getline(file, line); ++number) {
    try {
      const std::vector<std::string> cells = split(line);
      doubt.stretches.push_back(stretch_of(cells));
      doubt.begin = doubt.stretches.back().begin - stamp_of_seconds(finite_number(cells[1]));
      doubt.way = coordinate(cells[8]);
    } catch (const InputError& error) {
      throw InputError(path.string() + ":" + std::to_string(number) + ": '" + line +
                       "' is no doubtful stretch (" + error.what() +
                       "); optimize_session writes the file anew");
    }
  }
  return doubt;
}

}  // namespace lidar_mapping::pipeline
