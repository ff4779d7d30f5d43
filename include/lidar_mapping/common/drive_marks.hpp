// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/common/loop.hpp"

namespace lidar_mapping {

/// Where a key frame lies on the path of the vehicle.
struct PathPoint {
  KeyFrameIndex index = 0;    ///< that of the key frame
  std::uint32_t segment = 0;  ///< of the drive: a merged session has at least one for each drive
  Stamp stamp = 0;            ///< that of the key frame
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();  ///< base_link in the map frame, m
};

/// A loop, and what became of it.
struct LoopMark {
  KeyFrameIndex from = 0;                     ///< the older key frame
  KeyFrameIndex to = 0;                       ///< the newer key frame
  Verdict verdict = Verdict::kUndecided;      ///< the newest of the graph
  std::string reason;                         ///< why, in a sentence
  LoopSource source = LoopSource::kPosition;  ///< how it was found
};

/// A section of the drive where the map is doubtful.
struct DoubtMark {
  std::string kind;             ///< lost, repeated, degraded, doubtful or degenerate
  Stamp begin = 0;              ///< stamp of its first scan
  Stamp end = 0;                ///< stamp of its last scan
  double length = 0.0;          ///< of its path, m
  double expected_error = 0.0;  ///< standard deviation of the position, m; infinite if unknown
  bool is_trusted = true;       ///< false: the map must not be relied on there
  std::vector<Eigen::Vector3d> path_map;  ///< its course in the map frame, m
};

/// What a display or a GIS shows beside the points of a map.
struct DriveMarks {
  std::vector<PathPoint> path;    ///< all key frames, by index
  std::vector<LoopMark> loops;    ///< loops with their verdicts
  std::vector<DoubtMark> doubts;  ///< sections that may be wrong
};

}  // namespace lidar_mapping
