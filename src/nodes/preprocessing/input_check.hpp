// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "lidar_mapping/preprocessing/input_validator.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"

namespace lidar_mapping::ros_border {

/// Validates the inputs of preprocessing_node in the first seconds of the data, and reports once
/// what they are and what is wrong with them, in the log and on /diagnostics.
class InputCheck {
 public:
  /// `context` outlives this object, and what `lookup` uses.
  InputCheck(NodeContext& context, const preprocessing::PreprocessingConfig& config,
             preprocessing::ExtrinsicLookup lookup);

  /// A cloud has come; its points are unpacked for as long as they are looked at.
  void add_scan(const CloudView& message, DecodedCloud& decoded);
  /// A sample has come.
  void add(const SensorInput<ImuSample>& input);
  void add(const SensorInput<VelocitySample>& input);
  void add(const SensorInput<GnssFix>& input);

 private:
  void report();

  NodeContext& context_;
  preprocessing::ExtrinsicLookup lookup_;
  std::unique_ptr<preprocessing::InputValidator> validator_;  ///< until it has reported
  std::optional<Stamp> first_scan_;
};

}  // namespace lidar_mapping::ros_border
