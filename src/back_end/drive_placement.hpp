// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/pose_graph/factor_graph.hpp"

#include "drive_graph.hpp"

namespace lidar_mapping::back_end {

// Rough placement, from where the solver finds its way.

/// Puts segments that a new loop ties to an older one beside it. Of several loops the one counts
/// with which the most others agree.
void connect_segments(DriveGraph& drive);

struct Georeference {
  bool newly_aligned = false;   ///< a part of the drive came to East-North-Up that was not there
  double rms_horizontal = 0.0;  ///< m, of the newest alignment; 0: there was none
  std::size_t inliers = 0;      ///< positions that the alignments rest on
};

/// Turns groups of segments to East-North-Up as soon as their tracks allow, or again if `again`.
Georeference georeference(DriveGraph& drive, const BackEndConfig& config, bool realign);

/// Moves stretches of the states onto the positions about them: drift over the whole track would
/// make every far position look false.
void shift_to_gnss(const DriveGraph& drive, const BackEndConfig& config,
                   pose_graph::FactorGraph& graph);

}  // namespace lidar_mapping::back_end
