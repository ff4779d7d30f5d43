// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/pipeline/kitti_folder.hpp"

namespace lidar_mapping::recordings {

/// Scans that can be read one by one, in the sensor's frame.
struct Recording {
  std::size_t size = 0;
  std::function<Scan(std::size_t)> scan;
  Pose T_base_sensor;  ///< by the transforms of the recording, else the identity
};

/// A folder as KITTI lays it out, or a bag or MCAP file with a topic of clouds (the first one,
/// unless `topic` names one) and, if it is there, /tf_static. Throws FileError or InputError.
Recording open_recording(const std::string& path, const std::string& topic,
                         const pipeline::KittiReadOptions& reading);

}  // namespace lidar_mapping::recordings
