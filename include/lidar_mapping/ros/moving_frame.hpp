// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/recorded_frames.hpp"

namespace lidar_mapping::ros_border {

/// Whether the vehicle moves by more than a metre in `frame` by the recording's /tf, as in frames
/// of a world or of an odometry: clouds in such a frame are no longer those of a sensor. It is
/// looked up at ten times of the recording. In a frame that /tf_static fixes to the vehicle it does
/// not move.
bool vehicle_moves_in(const BagSet& bags, const std::string& base_frame, const std::string& frame);

/// Adds the transforms of /tf_static or /tf (`topic`) that were recorded from `from` until `until`;
/// damaged messages are left out.
void add_recorded_frames(const BagSet& bags, const std::string& topic, Stamp from, Stamp until,
                         RecordedFrames& frames);

}  // namespace lidar_mapping::ros_border
