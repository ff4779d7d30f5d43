// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/ros/bag_set.hpp"

namespace lidar_mapping::ros_border {

/// Topics of the sensors; an empty one is not there.
struct SensorTopics {
  std::string points;    ///< sensor_msgs/PointCloud2
  std::string imu;       ///< sensor_msgs/Imu
  std::string velocity;  ///< one of velocity_types()
  std::string gnss;      ///< one of gnss_types()
};

/// What is to be looked at.
struct RecordingCheck {
  const BagSet* bags = nullptr;          ///< of one drive
  SensorTopics topics;                   ///< see topics_in()
  std::string base_frame = "base_link";  ///< the vehicle's
  double seconds = 0.0;                  ///< s of the beginning; 0: all of it
};

/// `wanted`, and of each sensor that it leaves out the launch file's topic if the bags have it,
/// else the one of its type with most messages; of clouds the one that is most likely a LiDAR's,
/// see cloud_topics(). Throws InputError if a topic that is wanted is not there with such a type.
SensorTopics topics_in(const BagSet& bags, SensorTopics wanted = {});

/// Looks at the messages of a recording and says, for points, imu, velocity and gnss in this order,
/// what came and what is wrong with it: see preprocessing::InputValidator. Transforms are those of
/// /tf and /tf_static. What of the bags is damaged is left out, and a fault of the points. Throws
/// FileError if a bag cannot be read at all.
std::vector<preprocessing::InputReport> check(const RecordingCheck& recording,
                                              const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::ros_border
