// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/run_datum.hpp"

#include <sstream>
#include <string>
#include <vector>

#include <ros/console.h>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/run_state.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// As text with all digits, because a ROS master may round numbers.
std::string to_text(const GeodeticDatum& datum) {
  return formatted("%.17g %.17g %.17g", datum.latitude_deg, datum.longitude_deg, datum.altitude_m);
}

}  // namespace

preprocessing::PreprocessingConfig with_datum_of_the_run(preprocessing::PreprocessingConfig config,
                                                         const ros::NodeHandle& node) {
  std::string text;
  if (config.use_datum || !node.getParam(kRunDatum, text)) return config;
  std::istringstream numbers(text);
  std::vector<double> datum(3);
  if (!(numbers >> datum[0] >> datum[1] >> datum[2])) return config;
  config.use_datum = true;
  config.datum = datum;
  ROS_WARN_STREAM("continuing with the GNSS datum " << text << " of the run before the restart");
  return config;
}

void store_datum_of_the_run(const GeodeticDatum& datum, const ros::NodeHandle& node) {
  node.setParam(kRunDatum, to_text(datum));
}

void end_datum_of_the_run(const ros::NodeHandle& node) { node.deleteParam(kRunDatum); }

}  // namespace lidar_mapping::ros_border
