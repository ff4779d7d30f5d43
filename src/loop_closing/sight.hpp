// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/loop_closing/birds_eye_view.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// Range of sight of a key frame, m: the distance within which four fifths of what stands around it
/// lie, by the area that they occupy. Some 10 m in rooms, 40 m in streets. Empty views see 0 m.
double range_of_sight(const BirdsEyeView& view);

/// Largest distance of two key frames (m) at which a match counts: max_loop_distance if it is set,
/// else the range of sight that both have, `sight` (m).
double loop_distance_limit(double sight, const LoopClosingConfig& config);

/// Least path length (m) between two key frames of a loop: accum_distance_thresh if it is set, else
/// twice the range of sight (m), at most 50 m.
double least_path_length(double sight, const LoopClosingConfig& config);

/// Path length (m) after a loop before the next search: min_edge_interval if it is set, else a
/// half of the range of sight (m), at most 5 m.
double search_interval(double sight, const LoopClosingConfig& config);

/// True if two key frames see nearly the same from nearly the same side: their distance (m) is a
/// small part of the range of sight (m) of both.
bool is_close(double distance, double sight);

/// Factor by which the lower bound of a match's standard deviations grows where the two key frames
/// are not close: at their distance (m), with the range of sight (m) of both.
double growth_of_error(double distance, double sight);

}  // namespace lidar_mapping::loop_closing
