// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

/// A recording and the part of it that is checked.
struct RecordingCheck {
  const BagSet* bags = nullptr;          ///< of one drive
  SensorTopics topics;                   ///< see topics_in()
  std::string base_frame = "base_link";  ///< the vehicle's
  double seconds = 0.0;  ///< length of the checked part from the beginning, s; 0: all of it
};

/// Checks the messages of a recording and reports, for points, imu, velocity and gnss in this
/// order, what was received and its faults: see preprocessing::InputValidator. Transforms are read
/// from /tf and /tf_static. Damaged parts of the bags are left out and reported as a fault of the
/// points, packets of an Ouster that came late as a warning. Throws FileError if a bag cannot be
/// read at all.
std::vector<preprocessing::InputReport> check(const RecordingCheck& recording,
                                              const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::ros_border
