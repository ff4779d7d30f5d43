#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
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

/// Throws std::logic_error for what is no number.
DoubtfulStretch stretch_of(const std::vector<std::string>& cells) {
  const auto doubt = doubt_of_state(cells.at(0));
  if (!doubt || cells.size() != kColumns) throw std::invalid_argument("cells");
  DoubtfulStretch stretch;
  stretch.doubt = *doubt;
  stretch.begin = std::stoll(cells[3]);
  stretch.end = std::stoll(cells[4]);
  stretch.scans = std::stoul(cells[5]);
  stretch.way_begin = std::stod(cells[6]);
  stretch.way = std::stod(cells[7]);
  stretch.place = {std::stod(cells[9]), std::stod(cells[10]), std::stod(cells[11])};
  stretch.expected_error = std::stod(cells[12]);
  stretch.lowest_probability = std::stod(cells[13]);
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
      doubt.begin = doubt.stretches.back().begin - from_seconds(std::stod(cells[1]));
      doubt.way = std::stod(cells[8]);
    } catch (const std::logic_error&) {
      throw InputError(path.string() + ":" + std::to_string(number) + ": '" + line +
                       "' is no doubtful stretch; optimize_session writes the file anew");
    }
  }
  return doubt;
}

}  // namespace lidar_mapping::pipeline
