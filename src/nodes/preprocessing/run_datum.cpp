// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/run_datum.hpp"

#include <sstream>
#include <string>

#include <ros/console.h>

#include "lidar_mapping/ros/run_state.hpp"

namespace lidar_mapping::ros_border {

preprocessing::PreprocessingConfig with_datum_of_the_run(preprocessing::PreprocessingConfig config,
                                                         const ros::NodeHandle& node) {
  std::string text;
  if (config.use_datum || !node.getParam(kRunDatum, text)) return config;
  std::istringstream numbers(text);
  const auto datum = read_datum(numbers);
  if (!datum) return config;
  config.use_datum = true;
  config.datum = {datum->latitude_deg, datum->longitude_deg, datum->altitude_m};
  ROS_WARN_STREAM("continuing with the GNSS datum " << text << " of the run before the restart");
  return config;
}

void store_datum_of_the_run(const GeodeticDatum& datum, const ros::NodeHandle& node) {
  node.setParam(kRunDatum, to_text(datum));
}

void end_datum_of_the_run(const ros::NodeHandle& node) { node.deleteParam(kRunDatum); }

}  // namespace lidar_mapping::ros_border
