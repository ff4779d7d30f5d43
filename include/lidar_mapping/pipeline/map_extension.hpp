// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/localization/localizer.hpp"

namespace lidar_mapping::pipeline {

/// A key frame of a drive that is localised in a map.
struct LocalizedKeyFrame {
  KeyFrame key_frame;                      ///< As the front end made it, without its cloud.
  localization::LocalizationResult place;  ///< What was claimed about the place of its scan.
};

/// A section of a drive that extends a map: key frames where the map does not know the
/// surroundings, and those before and behind them where it does, by which they are tied to it.
struct NewSection {
  std::size_t begin = 0;         ///< Position of its first key frame in the drive.
  std::size_t end = 0;           ///< Position behind that of its last key frame.
  double new_path_length = 0.0;  ///< Path length by odometry that is new to the map, m.
  /// Loops from the nearest key frame of the map to one of the drive, which was followed there.
  std::vector<Loop> ties;
};

/// Path lengths that the map does not know and that are left out all the same, m.
struct OmittedPaths {
  double never_found = 0.0;  ///< By odometry, they lead to no key frame that was followed.
  double too_short = 0.0;    ///< They are shorter than kLeastNewPathLength.
  double not_tied = 0.0;     ///< Fewer ties than kLeastTies hold them, or the graph refuses these.
};

/// What of a drive extends a map.
struct MapExtension {
  std::vector<NewSection> sections;  ///< In the order of the drive; they do not overlap.
  OmittedPaths omitted;              ///< The rest that is new.
};

/// m. Chosen: longer than a lorry, beside which the map does not show the surroundings either.
inline constexpr double kLeastNewPathLength = 10.0;
/// Ties of a section. Chosen: of three the graph sees which one contradicts the others.
inline constexpr std::size_t kLeastTies = 3;

/// Chooses the sections of a drive that extend a map, and ties them to it (doc/localization.md).
/// `drive` is in the order of the drive; `map` holds the newest poses of the map in which it was
/// localised, at least one if a key frame was found there.
MapExtension plan_extension(const std::vector<LocalizedKeyFrame>& drive, const KeyFramePoses& map);

}  // namespace lidar_mapping::pipeline
