#pragma once

#include <memory>
#include <string>

#include <rosbag/bag.h>

namespace lidar_mapping::ros_border {

/// The bag, to be read. Throws FileError, which says what to do, where there is no such file, where
/// it is none that rosbag reads, and where the recording was broken off.
std::unique_ptr<rosbag::Bag> open_bag(const std::string& path);

}  // namespace lidar_mapping::ros_border
