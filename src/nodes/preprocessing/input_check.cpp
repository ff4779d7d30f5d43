// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/input_check.hpp"

#include <utility>

namespace lidar_mapping::ros_border {

namespace {

/// Duration of the data after which the input validator reports, s. Chosen: enough for rates, units
/// and gaps, and the person who started the nodes is still there.
constexpr double kValidationTime = 5.0;

}  // namespace

InputCheck::InputCheck(NodeContext& context, const preprocessing::PreprocessingConfig& config,
                       preprocessing::ExtrinsicLookup lookup)
    : context_(context),
      lookup_(std::move(lookup)),
      validator_(std::make_unique<preprocessing::InputValidator>(config)) {}

void InputCheck::add_scan(const CloudView& message, DecodedCloud& decoded) {
  if (!validator_) return;
  decoded.scan.unpack();
  validator_->add_scan(summary_of(message, decoded));
  if (!first_scan_) first_scan_ = decoded.scan.stamp;
  if (to_seconds(decoded.scan.stamp - *first_scan_) < kValidationTime) return;
  report();
  validator_.reset();
}

void InputCheck::add(const SensorInput<ImuSample>& input) {
  if (validator_) validator_->add_imu(input.sample, input.frame_id);
}

void InputCheck::add(const SensorInput<VelocitySample>& input) {
  if (validator_) validator_->add_velocity(input.sample, input.frame_id);
}

void InputCheck::add(const SensorInput<GnssFix>& input) {
  if (validator_) validator_->add_gnss(input.sample, input.frame_id);
}

void InputCheck::report() {
  for (const preprocessing::InputReport& input : validator_->report(lookup_)) {
    ROS_INFO_STREAM(input.input << ": " << input.found);
    context_.diagnostics.set(input.input, input.found);
    for (const preprocessing::CheckDiagnostic& diagnostic : input.diagnostics) {
      ROS_WARN_STREAM(input.input << ": " << sentence(diagnostic));
    }
  }
}

}  // namespace lidar_mapping::ros_border
