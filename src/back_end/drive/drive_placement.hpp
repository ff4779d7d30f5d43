// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

// Approximate poses from which the solver converges.

/// Moves segments that a new loop connects to an older segment next to that segment. Of several
/// loops, the one is used with which most others agree. Where the older one is not in
/// East-North-Up, the others are not any more, either.
void connect_segments(DriveGraph& drive);

struct Georeference {
  bool newly_aligned = false;   ///< segments were aligned that were not in East-North-Up before
  double rms_horizontal = 0.0;  ///< RMS error of the last alignment, m; 0: there was none
  std::size_t inliers = 0;      ///< number of positions that agree with the alignments
};

/// Aligns groups of connected segments to East-North-Up as soon as their tracks are long enough.
/// With `realign`, groups that are aligned already are aligned again.
Georeference georeference(DriveGraph& drive, const BackEndConfig& config, bool realign);

/// Moves sections of the states onto the positions near them. Otherwise the drift over the whole
/// track would make correct positions far away look like outliers.
void shift_to_gnss(const DriveGraph& drive, const BackEndConfig& config,
                   pose_graph::FactorGraph& graph);

}  // namespace lidar_mapping::back_end
