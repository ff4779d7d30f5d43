// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/ros/recording_check.hpp"

namespace lidar_mapping::recordings {

/// A drive in one or several bags, which are read as one in the order of their times. The topic of
/// a sensor is that of `wanted`, else that of the launch file, else the topic of the sensor's type
/// with most messages. Frames are read from /tf_static and the beginning of /tf. Throws FileError
/// for unreadable files, InputError for a topic that no bag has.
class BagInput : public pipeline::InputSource {
 public:
  BagInput(const std::vector<std::string>& paths, const ros_border::SensorTopics& wanted,
           const std::string& base_frame, const preprocessing::PreprocessingConfig& config);
  ~BagInput() override;

  std::optional<pipeline::Input> next() override;
  void skip_to(Stamp stamp) override;
  Stamp begin() const override;
  Stamp end() const override;
  std::optional<Pose> T_base(const std::string& frame_id) const override;
  std::vector<std::string> take_messages() override;

  const ros_border::SensorTopics& topics() const;
  /// Message for the user if no transform leads from the scans to `base_frame`, so that their frame
  /// is used instead; else empty.
  const std::string& frames_notice() const;
  /// Checks the sensors in the first seconds of the recording.
  std::vector<preprocessing::InputReport> examine(double seconds) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::recordings
