// SPDX-License-Identifier: BSD-3-Clause
#include "examined_drive.hpp"

#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "lidar_mapping/common/csv.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "localization_record.hpp"
#include "run_record.hpp"

namespace lidar_mapping::report {

namespace {

namespace fs = std::filesystem;
using localization::LocalizationState;

constexpr const char* kTable = "localization.csv";
constexpr const char* kOdometry = "trajectory/laser_odom_scans.tum";
constexpr const char* kRemedy = "; localize_bag writes the files again";

/// Those of the columns that are read; a table may have others.
constexpr const char* kColumns[] = {"stamp",    "state", "x",       "y",     "z",
                                    "qx",       "qy",    "qz",      "qw",    "agreement",
                                    "coverage", "path",  "segment", "reason"};

/// Cells of a row by the names of their columns.
using Row = std::map<std::string, std::string>;

Row row_of(const std::vector<std::string>& names, const std::string& line) {
  const std::vector<std::string> cells = csv_cells(line);
  if (cells.size() != names.size()) {
    throw InputError(std::to_string(cells.size()) + " cells instead of " +
                     std::to_string(names.size()));
  }
  Row row;
  for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = cells[i];
  return row;
}

LocalizationState state_of(const std::string& word) {
  for (const LocalizationState state :
       {LocalizationState::kSearching, LocalizationState::kFollowing, LocalizationState::kBesideMap,
        LocalizationState::kLost}) {
    if (word == to_string(state)) return state;
  }
  throw InputError("there is no such state");
}

double fraction(const std::string& word) {
  const double value = finite_number(word);
  if (value < 0.0 || value > 1.0) throw InputError("'" + word + "' is not between 0 and 1");
  return value;
}

Pose pose_of(const Row& row) {
  const auto number = [&](const char* name) { return coordinate(row.at(name)); };
  const Eigen::Quaterniond rotation(number("qw"), number("qx"), number("qy"), number("qz"));
  if (std::abs(rotation.norm() - 1.0) > 0.5) throw InputError("quaternion is not of unit length");
  return {rotation.normalized(), {number("x"), number("y"), number("z")}};
}

ExaminedScan scan_of(const Row& row) {
  constexpr std::int64_t kLastSegment = std::numeric_limits<std::uint32_t>::max();
  ExaminedScan scan;
  scan.stamp = stamp_of_seconds(row.at("stamp"));
  scan.state = state_of(row.at("state"));
  if (has_pose(scan.state)) scan.T_map_base = pose_of(row);
  scan.path = coordinate(row.at("path"));
  if (scan.path < 0.0) throw InputError("a path is not negative");
  scan.segment = static_cast<std::uint32_t>(whole_number(row.at("segment"), 0, kLastSegment));
  scan.agreement = fraction(row.at("agreement"));
  scan.coverage = fraction(row.at("coverage"));
  scan.reason = row.at("reason");
  return scan;
}

void check_order(const ExaminedScan& before, const ExaminedScan& scan) {
  if (scan.stamp <= before.stamp) throw InputError("the stamp is not after the one before");
  if (scan.path < before.path) throw InputError("the path is shorter than before");
  if (scan.segment < before.segment) throw InputError("the segment is one before");
}

std::vector<std::string> names_of_columns(const fs::path& path, const std::string& head) {
  std::vector<std::string> names = csv_cells(head);
  for (const char* column : kColumns) {
    if (contains(names, column)) continue;
    throw InputError(path.string() + " has no column '" + column + "'" + kRemedy);
  }
  return names;
}

std::vector<ExaminedScan> read_table(const fs::path& path) {
  std::ifstream file = open_for_reading(path);
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = names_of_columns(path, line);
  std::vector<ExaminedScan> scans;
  for (int number = 2; std::getline(file, line); ++number) {
    try {
      ExaminedScan scan = scan_of(row_of(names, line));
      if (!scans.empty()) check_order(scans.back(), scan);
      scans.push_back(std::move(scan));
    } catch (const InputError& error) {
      throw InputError(path.string() + ":" + std::to_string(number) + ": " + error.what() +
                       kRemedy);
    }
  }
  if (scans.empty()) throw InputError(path.string() + " has no scan" + kRemedy);
  return scans;
}

void add_odometry(const fs::path& path, std::vector<ExaminedScan>& scans) {
  const std::vector<StampedPose> poses = read_trajectory(path.string()).poses;
  const bool has_scans = std::equal(
      poses.begin(), poses.end(), scans.begin(), scans.end(),
      [](const StampedPose& pose, const ExaminedScan& scan) { return pose.stamp == scan.stamp; });
  if (!has_scans) {
    throw InputError(path.string() + " does not hold the scans of " + kTable + kRemedy);
  }
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].T_odom_base = poses[i].pose;
}

void check_map(const fs::path& folder, const MapIdentity& localized_in, const MapIdentity& given) {
  const std::string difference = map_difference(localized_in, given);
  if (difference.empty()) return;
  throw InputError("the drive in " + folder.string() + " does not examine this map: " + difference +
                   "; localise it in this map with localize_bag");
}

/// A map agrees with the drive that made it, however wrong it is. Stamps that are no dates may be
/// the same in several drives.
void check_independence(const fs::path& folder, const std::vector<ExaminedScan>& scans,
                        const KeyFramePoses& map) {
  for (const KeyFramePose& pose : map.poses) {
    const auto found = first_not_before(scans, pose.stamp);
    if (found == scans.end() || found->stamp != pose.stamp || pose.stamp < kFirstDate) continue;
    throw InputError("the drive in " + folder.string() +
                     " does not examine this map, because the map was made from it: key frame " +
                     std::to_string(pose.index) +
                     " is one of its scans; localise another drive with localize_bag");
  }
}

}  // namespace

std::vector<ExaminedScan> read_examined_scans(const fs::path& folder) {
  std::vector<ExaminedScan> scans = read_table(folder / kTable);
  add_odometry(folder / kOdometry, scans);
  return scans;
}

ExaminedDrive read_examined_drive(const fs::path& folder, const KeyFramePoses& map,
                                  const fs::path& session) {
  const LocalizationRecord record = read_localization_record(folder);
  check_map(folder, record.map, identity_of(map, session));
  ExaminedDrive drive;
  drive.name = names_of_recordings({folder.string()}).front();
  drive.recordings = record.recordings;
  drive.scans = read_examined_scans(folder);
  check_independence(folder, drive.scans, map);
  return drive;
}

}  // namespace lidar_mapping::report
