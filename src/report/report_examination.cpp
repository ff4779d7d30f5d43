// SPDX-License-Identifier: BSD-3-Clause
#include "report_examination.hpp"

#include <algorithm>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include "examined_motion.hpp"
#include "examined_sections.hpp"

namespace lidar_mapping::report {

namespace {

using json::Json;
using localization::LocalizationState;

/// A drive with its scans where they were in the map.
struct Examination {
  const std::vector<ExaminedScan>& scans;
  const std::vector<ScanLocation> locations;
  const KeyFramePoses& map;

  /// Path to a scan from the one before, m.
  double step(std::size_t i) const { return i == 0 ? 0.0 : scans[i].path - scans[i - 1].path; }
  double seconds(std::size_t i) const { return to_seconds(scans[i].stamp - scans[0].stamp); }
};

/// Number of the scans for which `is_counted(i)`, and their path.
template <typename IsCounted>
Json scans_and_path(const Examination& drive, const IsCounted& is_counted) {
  std::size_t count = 0;
  double path = 0.0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (!is_counted(i)) continue;
    ++count;
    path += drive.step(i);
  }
  return {{"scans", count}, {"path_m", path}};
}

Json states(const Examination& drive) {
  Json figures;
  for (const LocalizationState state :
       {LocalizationState::kFollowing, LocalizationState::kBesideMap, LocalizationState::kLost,
        LocalizationState::kSearching}) {
    figures[to_string(state)] =
        scans_and_path(drive, [&](std::size_t i) { return drive.scans[i].state == state; });
  }
  return figures;
}

/// What the map covers of the drive since its place was found, and what of that was followed.
Json in_map(const Examination& drive) {
  const auto is_in_map = [&](std::size_t i) {
    return drive.locations[i].is_in_map && drive.scans[i].state != LocalizationState::kSearching;
  };
  Json figures = scans_and_path(drive, is_in_map);
  figures["followed"] = scans_and_path(drive, [&](std::size_t i) {
    return is_in_map(i) && drive.scans[i].state == LocalizationState::kFollowing;
  });
  return figures;
}

/// Of the first scan with a pose; null if there is none.
Json found_after(const Examination& drive) {
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (!has_pose(drive.scans[i].state)) continue;
    return {{"seconds", drive.seconds(i)}, {"metres", drive.scans[i].path - drive.scans[0].path}};
  }
  return nullptr;
}

/// Mean of the scans that were followed, and what a tenth of them is below; null if there are none.
Json over_followed(const Examination& drive, double ExaminedScan::*figure) {
  std::vector<double> values;
  for (const ExaminedScan& scan : drive.scans) {
    if (scan.state == LocalizationState::kFollowing) values.push_back(scan.*figure);
  }
  if (values.empty()) return nullptr;
  return {{"mean", evaluation::statistics_of(values).mean},
          {"lowest_tenth", quantile(values, 0.1)}};
}

/// Position of a scan in the map and its nearest key frame; null where they are not known.
Json place_of(const Examination& drive, std::size_t i) {
  const ScanLocation& location = drive.locations[i];
  Json figures = {{"key_frame", nullptr}, {"x", nullptr}, {"y", nullptr}};
  if (location.is_in_map) figures["key_frame"] = drive.map.poses[location.key_frame].index;
  if (!location.is_known) return figures;
  figures["x"] = location.T_map_base.translation.x();
  figures["y"] = location.T_map_base.translation.y();
  return figures;
}

/// The place of consecutive scans that were lost, from the last one before them on: the first that
/// the map covers, else the first.
std::size_t place_of_loss(const Examination& drive, std::size_t begin, std::size_t end) {
  const std::size_t first = begin == 0 ? begin : begin - 1;
  for (std::size_t i = first; i < end; ++i) {
    if (drive.locations[i].is_in_map) return i;
  }
  return first;
}

Json loss_of(const Examination& drive, std::size_t begin, std::size_t end) {
  const std::size_t at = place_of_loss(drive, begin, end);
  Json figures = place_of(drive, at);
  figures["in_map"] = drive.locations[at].is_in_map;
  figures["begin_s"] = drive.seconds(begin);
  figures["scans"] = end - begin;
  figures["path_m"] = drive.scans[end - 1].path - drive.scans[begin].path + drive.step(begin);
  figures["reason"] = drive.scans[begin].reason;
  return figures;
}

Json losses(const Examination& drive) {
  Json found = Json::array();
  const auto is_lost = [&](std::size_t i) {
    return i < drive.scans.size() && drive.scans[i].state == LocalizationState::kLost;
  };
  for (std::size_t begin = 0; begin < drive.scans.size(); ++begin) {
    if (!is_lost(begin)) continue;
    std::size_t end = begin;
    while (is_lost(end)) ++end;
    found.push_back(loss_of(drive, begin, end));
    begin = end;
  }
  return found;
}

/// A motion against odometry and the place at its end.
Json to_json(const Examination& drive, const MotionDifference& difference) {
  Json figures = place_of(drive, difference.to);
  figures["end_s"] = drive.seconds(difference.to);
  figures["error_m"] = difference.metres;
  figures["error_deg"] = difference.degrees;
  return figures;
}

Json against_odometry(const Examination& drive) {
  const std::vector<MotionDifference> differences = motion_differences(drive.scans);
  std::vector<double> metres;
  std::vector<double> degrees;
  Json rows = Json::array();
  for (const MotionDifference& difference : differences) {
    metres.push_back(difference.metres);
    degrees.push_back(difference.degrees);
    rows.push_back({drive.scans[difference.to].path, difference.metres, difference.degrees});
  }
  Json jumps = Json::array();
  for (const MotionDifference& jump : jumps_of(differences)) jumps.push_back(to_json(drive, jump));
  const auto largest =
      std::max_element(differences.begin(), differences.end(),
                       [](const auto& a, const auto& b) { return a.metres < b.metres; });
  const auto in_metres = evaluation::statistics_of(metres);
  const auto in_degrees = evaluation::statistics_of(degrees);
  return {{"delta_m", kComparedPath},
          {"motions", differences.size()},
          {"mean_m", in_metres.mean},
          {"rmse_m", in_metres.rmse},
          {"max_m", in_metres.max},
          {"rmse_deg", in_degrees.rmse},
          {"max_deg", in_degrees.max},
          {"largest", differences.empty() ? Json() : to_json(drive, *largest)},
          {"jumps", jumps},
          {"columns", {"distance", "error_m", "error_deg"}},
          {"rows", rows}};
}

Json sections(const Examination& drive) {
  Json rows = Json::array();
  for (const ExaminedSection& section :
       examined_sections(drive.scans, drive.locations, drive.map)) {
    const std::vector<KeyFramePose>& key_frames = drive.map.poses;
    const KeyFramePose& middle = key_frames[(section.first + section.last) / 2];
    const bool is_passed = section.scans > 0;
    rows.push_back({{"first_key_frame", key_frames[section.first].index},
                    {"last_key_frame", key_frames[section.last].index},
                    {"rows", {section.first, section.last}},
                    {"begin_m", section.begin},
                    {"x", middle.T_map_base.translation.x()},
                    {"y", middle.T_map_base.translation.y()},
                    {"passes", section.passes},
                    {"scans", section.scans},
                    {"followed", section.followed},
                    {"agreement", is_passed ? Json(section.agreement) : Json()},
                    {"coverage", is_passed ? Json(section.coverage) : Json()}});
  }
  return rows;
}

}  // namespace

Json examination_figures(const ExaminedDrive& drive, const KeyFramePoses& map) {
  const Examination examined{drive.scans, locations_of(drive.scans, map), map};
  return {{"name", drive.name},
          {"recordings", drive.recordings},
          {"scans", drive.scans.size()},
          {"path_m", drive.scans.back().path - drive.scans.front().path},
          {"seconds", examined.seconds(drive.scans.size() - 1)},
          {"states", states(examined)},
          {"found_after", found_after(examined)},
          {"in_map", in_map(examined)},
          {"agreement", over_followed(examined, &ExaminedScan::agreement)},
          {"coverage", over_followed(examined, &ExaminedScan::coverage)},
          {"losses", losses(examined)},
          {"odometry", against_odometry(examined)},
          {"section_m", kSectionLength},
          {"reach_m", kMapReach},
          {"sections", sections(examined)}};
}

}  // namespace lidar_mapping::report
