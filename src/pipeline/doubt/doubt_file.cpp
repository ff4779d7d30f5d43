// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/csv.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"

namespace lidar_mapping::pipeline {

namespace {

constexpr const char* kHeader =
    "kind,begin_s,end_s,begin_ns,end_ns,scans,way_begin_m,way_m,way_of_drive_m,x,y,z,"
    "expected_error_m,lowest_probability,first_key_frame,last_key_frame,trusted";

constexpr std::size_t kColumns = 17;     // by definition: cells of kHeader
constexpr std::size_t kOldColumns = 15;  // by definition: cells without the key frames

/// The cells of a line; an empty one at its end is missing.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells = csv_cells(line);
  if (cells.back().empty()) cells.pop_back();
  return cells;
}

/// A standard deviation; infinite if unknown.
double parse_error(const std::string& cell) {
  if (cell == "inf") return std::numeric_limits<double>::infinity();
  const double error = coordinate(cell);
  if (error < 0.0) throw InputError("an error is not negative");
  return error;
}

/// Both cells are empty where there are no key frames. Throws InputError.
std::optional<KeyFrameRange> parse_key_frames(const std::string& first, const std::string& last) {
  if (first.empty() && last.empty()) return std::nullopt;
  constexpr std::int64_t kMost = std::numeric_limits<KeyFrameIndex>::max();
  const std::int64_t first_index = whole_number(first, 0, kMost);
  return KeyFrameRange{static_cast<KeyFrameIndex>(first_index),
                       static_cast<KeyFrameIndex>(whole_number(last, first_index, kMost))};
}

/// Throws InputError.
DoubtfulSection section_of_cells(const std::vector<std::string>& cells) {
  if (cells.size() != kColumns && cells.size() != kOldColumns) {
    throw InputError(std::to_string(cells.size()) + " cells instead of " +
                     std::to_string(kColumns));
  }
  const auto doubt = doubt_of_state(cells[0]);
  if (!doubt) throw InputError("there is no such kind of doubt");
  constexpr std::int64_t kMaxScans = 1'000'000'000;  // chosen: three years at 10 Hz
  DoubtfulSection section;
  section.doubt = *doubt;
  section.begin = stamp_of_nanoseconds(cells[3]);
  section.end = stamp_of_nanoseconds(cells[4]);
  section.scans = static_cast<std::size_t>(whole_number(cells[5], 0, kMaxScans));
  section.path_begin = coordinate(cells[6]);
  section.path_length = coordinate(cells[7]);
  section.position = {coordinate(cells[9]), coordinate(cells[10]), coordinate(cells[11])};
  section.expected_error = parse_error(cells[12]);
  const double probability = coordinate(cells[13]);
  if (probability >= 0.0) section.lowest_probability = probability;
  if (cells.size() == kColumns) section.key_frames = parse_key_frames(cells[14], cells[15]);
  section.is_trusted = cells.back() == "yes";
  return section;
}

}  // namespace

void write_doubt(const DriveDoubt& doubt, const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << kHeader << '\n';
  for (const DoubtfulSection& s : doubt.sections) {
    text << to_string(s.doubt) << ',' << to_seconds(s.begin - doubt.begin) << ','
         << to_seconds(s.end - doubt.begin) << ',' << s.begin << ',' << s.end << ',' << s.scans
         << ',' << s.path_begin << ',' << s.path_length << ',' << doubt.path_length << ','
         << s.position.x() << ',' << s.position.y() << ',' << s.position.z() << ','
         << s.expected_error << ',' << s.lowest_probability.value_or(kUnknownProbability) << ',';
    s.key_frames ? text << s.key_frames->first << ',' << s.key_frames->last : text << ',';
    text << ',' << (s.is_trusted ? "yes" : "no") << '\n';
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
      const std::vector<std::string> cells = cells_of(line);
      doubt.sections.push_back(section_of_cells(cells));
      doubt.begin = doubt.sections.back().begin - stamp_of_seconds(finite_number(cells[1]));
      doubt.path_length = coordinate(cells[8]);
    } catch (const InputError& error) {
      throw InputError(path.string() + ":" + std::to_string(number) + ": '" + line +
                       "' is no doubtful section (" + error.what() +
                       "); optimize_session writes the file again");
    }
  }
  return doubt;
}

}  // namespace lidar_mapping::pipeline
