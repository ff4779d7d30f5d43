// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/ros/recording_check.hpp"

namespace lidar_mapping::recordings {

/// A drive in one or several bags, which are read as one in the order of their times.
class BagInput : public pipeline::InputSource {
 public:
  virtual const ros_border::SensorTopics& topics() const = 0;
  /// Message for the user if no transform leads from the scans to the base frame, so that their
  /// frame is used instead; else empty.
  virtual const std::string& frames_notice() const = 0;
  /// Checks the sensors in the first seconds of the recording.
  virtual std::vector<preprocessing::InputReport> examine(double seconds) const = 0;
};

/// The topic of a sensor is that of `wanted`, else that of the launch file, else the topic of the
/// sensor's type with most messages. Frames are read from /tf_static and the beginning of /tf.
/// Throws FileError for unreadable files, InputError for a topic that no bag has.
std::unique_ptr<BagInput> make_bag_input(const std::vector<std::string>& paths,
                                         const ros_border::SensorTopics& wanted,
                                         const std::string& base_frame,
                                         const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::recordings
