// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

#include "examined_drive.hpp"

namespace lidar_mapping::report {

/// m: within this distance of a key frame the map covers a location. Chosen: as kNewDistance in
/// map_extension.cpp, from which on a location is new to the map.
inline constexpr double kMapReach = 15.0;
/// m: path length of a section of the map. Chosen: a dozen scans in a street, so that their mean
/// means something, and short enough to find the place.
inline constexpr double kSectionLength = 20.0;

/// Where a scan was in the map.
struct ScanLocation {
  bool is_known = false;  ///< there is a pose
  /// By localisation, else by odometry from the nearest scan that has a pose: that before, or if
  /// there is none the one behind. Odometry has to lead there.
  Pose T_map_base;
  bool is_in_map = false;     ///< a key frame is less than kMapReach away
  std::size_t key_frame = 0;  ///< position of the nearest one in the poses of the map, if so
};

/// The location of each scan.
std::vector<ScanLocation> locations_of(const std::vector<ExaminedScan>& scans,
                                       const KeyFramePoses& map);

/// A section of the map's path and what a drive met there.
struct ExaminedSection {
  std::size_t first = 0;  ///< position of its first key frame in the poses of the map
  std::size_t last = 0;   ///< that of its last one
  double begin = 0.0;     ///< path length of the map up to its first key frame, m
  std::size_t passes = 0;
  std::size_t scans = 0;     ///< since the place was found, those that were lost included
  std::size_t followed = 0;  ///< how many of these were followed
  // Means over these scans; one that was lost counts as 0.
  double agreement = 0.0;
  double coverage = 0.0;
};

/// All sections of the map, in the order of its path. A scan belongs to that of the nearest key
/// frame, if the map covers its location.
std::vector<ExaminedSection> examined_sections(const std::vector<ExaminedScan>& scans,
                                               const std::vector<ScanLocation>& locations,
                                               const KeyFramePoses& map);

}  // namespace lidar_mapping::report
