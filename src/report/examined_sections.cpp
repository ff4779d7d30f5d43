// SPDX-License-Identifier: BSD-3-Clause
#include "examined_sections.hpp"

#include <map>
#include <utility>

#include "lidar_mapping/common/path_length.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::report {

namespace {

using localization::LocalizationState;

/// m: least path length between two passes. Chosen: as kMinPathBetweenPasses in
/// pass_misalignment.cpp, because a turning vehicle comes back sooner.
constexpr double kMinPathBetweenPasses = 40.0;

/// The key frames of a map in squares with edges of kMapReach, so that few are looked at.
class KeyFrameSquares {
 public:
  explicit KeyFrameSquares(const std::vector<KeyFramePose>& map) : map_(map) {
    for (std::size_t i = 0; i < map.size(); ++i) squares_[square_of(position(i))].push_back(i);
  }

  void find_nearest(ScanLocation& location) const {
    const Square middle = square_of(location.T_map_base.translation);
    double least = kMapReach;
    for (const std::int64_t x : {middle.first - 1, middle.first, middle.first + 1}) {
      for (const std::int64_t y : {middle.second - 1, middle.second, middle.second + 1}) {
        const auto square = squares_.find({x, y});
        if (square != squares_.end()) find_nearer(square->second, least, location);
      }
    }
  }

 private:
  using Square = std::pair<std::int64_t, std::int64_t>;

  static Square square_of(const Eigen::Vector3d& p_map) {
    return {floor_to_int(p_map.x() / kMapReach), floor_to_int(p_map.y() / kMapReach)};
  }
  const Eigen::Vector3d& position(std::size_t i) const { return map_[i].T_map_base.translation; }

  /// Takes a key frame that is nearer than `least`, m.
  void find_nearer(const std::vector<std::size_t>& key_frames, double& least,
                   ScanLocation& location) const {
    for (const std::size_t i : key_frames) {
      const double distance = (position(i) - location.T_map_base.translation).norm();
      if (distance >= least) continue;
      least = distance;
      location.is_in_map = true;
      location.key_frame = i;
    }
  }

  const std::vector<KeyFramePose>& map_;
  std::map<Square, std::vector<std::size_t>> squares_;
};

/// Carries a location to the next or previous scan, if odometry leads there.
void carry(const ScanLocation& from_location, const ExaminedScan& from, const ExaminedScan& to,
           ScanLocation& to_location) {
  if (to_location.is_known || !from_location.is_known || from.segment != to.segment) return;
  to_location.is_known = true;
  to_location.T_map_base = from_location.T_map_base * (from.T_odom_base.inverse() * to.T_odom_base);
}

std::vector<ExaminedSection> sections_of(const KeyFramePoses& map) {
  const std::vector<double> distances = travelled_distances(map);
  std::vector<ExaminedSection> sections;
  std::int64_t last_number = -1;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const std::int64_t number = floor_to_int(distances[i] / kSectionLength);
    if (number != last_number) {
      sections.emplace_back();
      sections.back().first = i;
      sections.back().begin = distances[i];
    }
    sections.back().last = i;
    last_number = number;
  }
  return sections;
}

/// For each key frame the position of its section.
std::vector<std::size_t> section_numbers(const std::vector<ExaminedSection>& sections,
                                         std::size_t key_frames) {
  std::vector<std::size_t> numbers(key_frames, 0);
  for (std::size_t k = 0; k < sections.size(); ++k) {
    for (std::size_t i = sections[k].first; i <= sections[k].last; ++i) numbers[i] = k;
  }
  return numbers;
}

void add(const ExaminedScan& scan, double path_since_last, ExaminedSection& section) {
  if (section.scans == 0 || path_since_last > kMinPathBetweenPasses) ++section.passes;
  ++section.scans;
  if (scan.state == LocalizationState::kFollowing) ++section.followed;
  if (scan.state == LocalizationState::kLost) return;
  section.agreement += scan.agreement;
  section.coverage += scan.coverage;
}

}  // namespace

std::vector<ScanLocation> locations_of(const std::vector<ExaminedScan>& scans,
                                       const KeyFramePoses& map) {
  std::vector<ScanLocation> locations(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    locations[i].is_known = has_pose(scans[i].state);
    if (locations[i].is_known) locations[i].T_map_base = scans[i].T_map_base;
    if (i > 0) carry(locations[i - 1], scans[i - 1], scans[i], locations[i]);
  }
  for (std::size_t i = scans.size(); i-- > 1;) {
    carry(locations[i], scans[i], scans[i - 1], locations[i - 1]);
  }
  const KeyFrameSquares key_frames(map.poses);
  for (ScanLocation& location : locations) {
    if (location.is_known) key_frames.find_nearest(location);
  }
  return locations;
}

std::vector<ExaminedSection> examined_sections(const std::vector<ExaminedScan>& scans,
                                               const std::vector<ScanLocation>& locations,
                                               const KeyFramePoses& map) {
  std::vector<ExaminedSection> sections = sections_of(map);
  const std::vector<std::size_t> numbers = section_numbers(sections, map.poses.size());
  std::vector<double> last_paths(sections.size(), 0.0);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!locations[i].is_in_map || scans[i].state == LocalizationState::kSearching) continue;
    const std::size_t k = numbers[locations[i].key_frame];
    add(scans[i], scans[i].path - last_paths[k], sections[k]);
    last_paths[k] = scans[i].path;
  }
  for (ExaminedSection& section : sections) {
    if (section.scans == 0) continue;
    section.agreement /= static_cast<double>(section.scans);
    section.coverage /= static_cast<double>(section.scans);
  }
  return sections;
}

}  // namespace lidar_mapping::report
