#pragma once

#include <string>
#include <vector>

#include <rosbag/bag.h>

#include "lidar_mapping/preprocessing/finding.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

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
  std::vector<const rosbag::Bag*> bags;  ///< of one drive, open for reading
  SensorTopics topics;
  std::string base_frame = "base_link";
  double seconds = 0.0;  ///< of the beginning; 0: all of it
};

/// `wanted`, and of each sensor that it leaves out the launch file's topic if the bags have it,
/// else the one of its type with most messages; of clouds the one that is most likely a LiDAR's,
/// see cloud_topics(). Throws InputError if a topic that is wanted is not there with such a type.
SensorTopics topics_in(const std::vector<const rosbag::Bag*>& bags, SensorTopics wanted = {});

/// Looks at the messages of a recording and says, for points, imu, velocity and gnss in this order,
/// what came and what is wrong with it: see preprocessing::InputDoctor. Transforms are those of /tf
/// and /tf_static. Throws rosbag::BagException if a bag cannot be read.
std::vector<preprocessing::InputReport> check(const RecordingCheck& recording,
                                              const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::ros_border
