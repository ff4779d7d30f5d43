// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/merging_check.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::ros_border {

std::string merging_problem(const RecordedCloud& cloud, const CloudReader& reader) try {
  const preprocessing::RawScan scan = reader.read(cloud).scan;
  return scan.cloud.has_times() ? "" : "their points have no times";
} catch (const InputError& error) {
  return error.what();
}

}  // namespace lidar_mapping::ros_border
