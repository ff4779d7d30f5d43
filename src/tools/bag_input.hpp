#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"

namespace lidar_mapping::tools {

/// Names of topics; empty where the sensor is absent, or not named yet.
struct SensorTopics {
  std::string points, imu, velocity, gnss;
};

/// A drive in one or several bags, which are read as one in the order of their times. Of each
/// sensor the topic is read that `wanted` names; where it names none, the one of the launch file,
/// and where the bags lack that one, the topic of the sensor's type with most messages. Frames come
/// from /tf_static and /tf. Throws FileError for what cannot be read, InputError for a topic that
/// no bag has.
class BagInput : public pipeline::InputSource {
 public:
  BagInput(const std::vector<std::string>& paths, const SensorTopics& wanted,
           const std::string& base_frame, const preprocessing::PreprocessingConfig& config);
  ~BagInput() override;

  std::optional<pipeline::Input> next() override;
  Stamp begin() const override;
  Stamp end() const override;
  std::optional<Pose> T_base(const std::string& frame_id) const override;

  const SensorTopics& topics() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::tools
