// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/ros/bag_set.hpp"

namespace lidar_mapping::ros_border {

/// Topics of the sensors; empty if there is none.
struct SensorTopics {
  std::string points;    ///< sensor_msgs/PointCloud2
  std::string imu;       ///< sensor_msgs/Imu
  std::string velocity;  ///< one of velocity_types()
  std::string gnss;      ///< one of gnss_types()
};

/// A recording and the part of it that is checked.
struct RecordingCheck {
  const BagSet* bags = nullptr;          ///< of one drive
  SensorTopics topics;                   ///< see topics_in()
  std::string base_frame = "base_link";  ///< the vehicle's
  double seconds = 0.0;  ///< length of the checked part from the beginning, s; 0: all of it
};

/// Completes `wanted`: each sensor without a topic gets that of the launch file if the bags have
/// it, else the topic of its type with most messages; for clouds that which is most likely a
/// LiDAR's, see cloud_topics(). Throws InputError if a requested topic does not exist with such a
/// type.
SensorTopics topics_in(const BagSet& bags, SensorTopics wanted = {});

/// Checks the messages of a recording and reports, for points, imu, velocity and gnss in this
/// order, what was received and its faults: see preprocessing::InputValidator. Transforms are read
/// from /tf and /tf_static. Damaged parts of the bags are left out and reported as a fault of the
/// points. Throws FileError if a bag cannot be read at all.
std::vector<preprocessing::InputReport> check(const RecordingCheck& recording,
                                              const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::ros_border
