// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

#include "gnss/local_frame.hpp"
#include "motion/motion_sensors.hpp"
#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// Messages about the inputs while they are synchronised. Each subject is reported once.
class InputDiagnostics : public DiagnosticLog {
 public:
  /// Reports how the motion during the scans is compensated.
  void motion(MotionSource source, bool has_times) {
    if (!has_times) {
      return inform("motion none",
                    "points: no point times; the front end finds out whether the motion within the "
                    "sweep was removed");
    }
    if (source == MotionSource::kNone) {
      return inform("motion later",
                    "points: neither IMU nor velocity over the scan; the points keep their times "
                    "and the front end compensates");
    }
    const std::string name = source == MotionSource::kImu        ? "IMU (rotation only)"
                             : source == MotionSource::kVelocity ? "velocity"
                                                                 : "IMU and velocity";
    inform("motion " + name, "points: motion during the scan compensated by " + name);
  }
  void time_went_back(const std::string& input, Stamp jump) {
    reset("reset");
    warn("reset", input + formatted(": time went back by %.1f s", to_seconds(jump)) +
                      "; all buffers are empty now (a recording that starts again?)");
  }
  void stray_stamp(const std::string& input, Stamp jump) {
    warn("stray " + input,
         input +
             formatted(": a message was dropped, because its stamp is %.1f s %s all earlier ones "
                       "(messages with stamps near it are accepted if more of them follow)",
                       std::abs(to_seconds(jump)), jump > 0 ? "after" : "before"));
  }
  void rejected_fix(const std::string& problem) {
    warn("gnss " + kind_of_problem(problem), "gnss: fix refused: " + problem);
  }
  void rejected_scan(Stamp stamp) {
    warn("order", stamp == 0 ? "points: the stamps are 0; the driver must stamp its clouds"
                             : "points: a scan came with the stamp of an earlier one or after a "
                               "later one; it was dropped");
  }
  void too_few_points() {
    warn("empty",
         "points: a scan had fewer than min_points points after the filters; check "
         "distance_near_thresh, distance_far_thresh and vehicle_box");
  }
  void rejected_heading() {
    warn("heading",
         "imu: its heading does not agree with the course over ground; it is not used (set "
         "imu_orientation to ENU if it is true nevertheless)");
  }
  void implausible_gyro() {
    warn("gyro",
         "imu: its rates are beyond 12 rad/s or far beyond the velocity's, as if they were in "
         "degrees/s; they are not used (set imu_angular_unit to DEG_PER_S)");
  }
  void clipped_gyro(double limit) {
    warn("gyro limit",
         formatted("imu: its rates end at %.1f rad/s, where the sensor turns faster; the gyro is "
                   "not used for these scans (set a larger range in its driver)",
                   limit));
  }
  void rejected_acceleration(const std::string& sentence) {
    warn("acceleration", "imu: " + sentence);
  }
  void rejected_velocity(VelocityProblem problem, const std::string& sentence) {
    warn("velocity " + std::to_string(static_cast<int>(problem)), "velocity: " + sentence);
  }
  void missing_transform(const std::string& input, const std::string& frame_id) {
    const std::string what = frame_id.empty()
                                 ? "the messages name no frame; set header.frame_id"
                                 : "no transform from '" + frame_id +
                                       "' to the vehicle's frame; publish it on /tf_static (or set "
                                       "base_frame to it)";
    warn("tf " + input + frame_id, input + ": " + what);
  }
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
  static constexpr Stamp kOtherClock = from_seconds(10.0);  // no sensor has such a delay

  void other_clock(const std::string& input, Stamp ahead, Stamp behind) {
    const Stamp most = std::max(ahead, behind);
    if (most <= kOtherClock) return;
    const bool is_ahead = ahead > behind;
    warn("clock " + input,
         formatted("%s: its stamps are %.1f s %s those of the scans; %s it another clock? "
                   "(%s_time_offset)",
                   input.c_str(), to_seconds(most), is_ahead ? "ahead of" : "behind",
                   is_ahead ? "is" : "has it ended, or is", input.c_str()));
  }
};

}  // namespace lidar_mapping::preprocessing
