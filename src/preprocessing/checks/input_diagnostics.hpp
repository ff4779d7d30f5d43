// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>

#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

#include "motion/motion_sensors.hpp"
#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// Messages about the inputs while they are synchronised. Each subject is reported once.
class InputDiagnostics : public DiagnosticLog {
 public:
  /// Reports how the motion during the scans is compensated.
  void motion(MotionSource source, bool has_times);
  void time_went_back(const std::string& input, Stamp jump);
  void stray_stamp(const std::string& input, Stamp jump);
  void rejected_fix(const std::string& problem);
  void rejected_scan(Stamp stamp);
  void too_few_points();
  void rejected_heading();
  void implausible_gyro();
  void clipped_gyro(double limit);
  void rejected_acceleration(const std::string& sentence);
  void rejected_velocity(VelocityProblem problem, const std::string& sentence);
  void missing_transform(const std::string& input, const std::string& frame_id);
  /// Reports why a sensor that is present has no value at `stamp`, unless this is a mere gap.
  /// `newest` is the stamp of its last sample.
  template <typename Sample>
  void no_value(const SensorStream<Sample>& stream, Stamp newest, Stamp stamp,
                const Extrinsics& extrinsics) {
    if (stream.buffer().empty()) return;
    if (!extrinsics.T_base(stream.frame_id())) {
      return missing_transform(stream.name(), stream.frame_id());
    }
    other_clock(stream.name(), stream.buffer().oldest().stamp - stamp,
                stamp - std::max(newest, stream.buffer().newest().stamp));
  }

 private:
  void other_clock(const std::string& input, Stamp ahead, Stamp behind);
};

}  // namespace lidar_mapping::preprocessing
