// SPDX-License-Identifier: BSD-3-Clause
#include "back_end/optimization_answer.hpp"

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Largest motion of a pose that counts as none, m. Chosen: it is not visible.
constexpr double kUnmoved = 0.001;

std::string with_unit(double value, int digits, const char* unit) {
  return formatted("%.*f %s", digits, value, unit);
}

std::string metres(double length) {
  if (length < kUnmoved) return "less than a millimetre";
  return with_unit(length, length < 1.0 ? 3 : 2, "m");
}

/// Position in the drive as time and coordinates, by which it is found in a player and in rviz.
std::string place(const back_end::PoseChange& change, Stamp begin) {
  return "key frame " + std::to_string(change.farthest) + ", " +
         with_unit(to_seconds(change.stamp - begin), 1, "s") + " into the drive";
}

std::string movement(const MapOptimization& done) {
  if (done.moved.largest < kUnmoved) {
    return "No pose moved by a millimetre or more: the map already agreed with all measurements.";
  }
  return "The poses moved by " + metres(done.moved.mean) + " on average and by at most " +
         metres(done.moved.largest) + " (" + place(done.moved, done.begin) + ").";
}

std::string correction(const MapOptimization& done) {
  if (done.corrected.largest < kUnmoved) return "The map is the same as by odometry alone.";
  return "They now differ from odometry alone by " + metres(done.corrected.mean) +
         " on average and by at most " + metres(done.corrected.largest) + " (" +
         place(done.corrected, done.begin) + ").";
}

std::string evidence(const char* what, std::size_t used, std::size_t refused, const char* none) {
  if (used + refused == 0) return none;
  return std::string(what) + ": " + std::to_string(used) + " used, " + std::to_string(refused) +
         " refused.";
}

std::string sentences(const MapOptimization& done) {
  const back_end::OptimizationReport& report = done.report;
  if (!report.success) return report.message;
  std::string text =
      std::to_string(report.key_frames) + " key frames optimised in " +
      with_unit(report.seconds, 2, "s") + ". " + movement(done) + " " + correction(done) + " " +
      evidence("Loops", report.loops_used, report.loops_refused,
               "No loops: no place was recognised.") +
      " " + evidence("GNSS fixes", report.gnss_used, report.gnss_refused, "No GNSS fixes.");
  for (const std::string& remark : report.remarks) text += " Note: " + remark + ".";
  return text + " Session: " + done.session +
         ". To write the map to the folder map of the session, call: rosservice call " +
         done.save_map + " '{}'.";
}

}  // namespace

OptimizeMap::Response to_answer(const MapOptimization& optimization) {
  const back_end::OptimizationReport& report = optimization.report;
  OptimizeMap::Response answer;
  answer.success = report.success;
  answer.message = sentences(optimization);
  answer.key_frames = static_cast<std::uint32_t>(report.key_frames);
  answer.loops_used = static_cast<std::uint32_t>(report.loops_used);
  answer.loops_refused = static_cast<std::uint32_t>(report.loops_refused);
  answer.gnss_used = static_cast<std::uint32_t>(report.gnss_used);
  answer.gnss_refused = static_cast<std::uint32_t>(report.gnss_refused);
  answer.cost_before = report.cost_before;
  answer.cost_after = report.cost_after;
  answer.seconds = report.seconds;
  answer.moved_mean = optimization.moved.mean;
  answer.moved_largest = optimization.moved.largest;
  answer.moved_farthest = optimization.moved.farthest;
  answer.moved_farthest_stamp = to_ros(optimization.moved.stamp);
  answer.corrected_mean = optimization.corrected.mean;
  answer.corrected_largest = optimization.corrected.largest;
  answer.corrected_farthest = optimization.corrected.farthest;
  answer.corrected_farthest_stamp = to_ros(optimization.corrected.stamp);
  answer.session = optimization.session;
  return answer;
}

}  // namespace lidar_mapping::ros_border
