// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::ros_border {

/// The configuration with the datum of the current run, if there is one, so that the map's frame
/// stays in place when preprocessing_node is restarted during a drive.
preprocessing::PreprocessingConfig with_datum_of_the_run(preprocessing::PreprocessingConfig config,
                                                         const ros::NodeHandle& node);

/// Keeps the datum for the node that is started after a crash.
void store_datum_of_the_run(const GeodeticDatum& datum, const ros::NodeHandle& node);

/// A regular shutdown ends the run.
void end_datum_of_the_run(const ros::NodeHandle& node);

}  // namespace lidar_mapping::ros_border
