// SPDX-License-Identifier: BSD-3-Clause
#include "display/drive_status.hpp"

#include <sstream>

#include "lidar_mapping/common/text.hpp"

#include "display/marker_layer.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

constexpr double kTextHeight = 5.0;      // m, of a capital; chosen: legible from above a town
constexpr double kOverVehicle = 12.0;    // m; chosen: clear of the vehicle and of what is near
constexpr std::size_t kLineLength = 45;  // characters; chosen: longer lines leave the view

/// Breaks the text between words, because a reason can be a long sentence.
std::string broken(const std::string& text) {
  std::istringstream words(text);
  std::string result;
  std::size_t length = 0;
  for (std::string word; words >> word; length += word.size() + 1) {
    if (length > 0 && length + word.size() > kLineLength) {
      result += '\n';
      length = 0;
    } else if (length > 0) {
      result += ' ';
    }
    result += word;
  }
  return result;
}

/// What to do after a drive.
std::string next_call(const DriveStatus& status) {
  const std::string optimize = "rosservice call " + status.optimize_map;
  const std::string save = "to write the map: rosservice call " + status.save_map + " '{}'";
  if (!status.since_optimized) return "no more scans; at the end of the drive: " + optimize;
  if (*status.since_optimized == 0) return "optimised; " + save;
  return "optimised; key frames since then: " + std::to_string(*status.since_optimized) +
         "\nto include them: " + optimize + "\n" + save;
}

std::string headline(const DriveStatus& status) {
  if (status.silent || (status.state.empty() && status.since_optimized)) return next_call(status);
  if (status.state.empty()) {
    return "waiting for scans ..." + (status.problem.empty() ? "" : "\n" + broken(status.problem));
  }
  if (status.state == "degenerate")
    return "degenerate: the points do not determine all of the motion";
  if (status.state == "doubtful")
    return "doubtful: the step may be off by more than 0.3 m or 1 deg";
  if (status.state == "degraded") return "degraded: scans match the map poorly";
  if (status.state == "lost") return "lost: scans do not match the map";
  return status.state;
}

std::string figures(const DriveStatus& status) {
  return formatted("%.2f km, %zu key frames, %zu loops (%zu refused)", status.length / 1000.0,
                   status.key_frames, status.loops_used, status.loops_refused);
}

std_msgs::ColorRGBA color_of(const DriveStatus& status) {
  if (!status.silent && status.state == "lost") return color(1.0F, 0.25F, 0.2F);
  const bool is_poor = contains({"degenerate", "doubtful", "degraded"}, status.state);
  return !status.silent && is_poor ? color(1.0F, 0.6F, 0.1F) : color(1.0F, 1.0F, 1.0F);
}

}  // namespace

Marker status_text(const DriveStatus& status, const std::string& map_frame,
                   const std::string& base_frame) {
  const bool on_the_way = status.key_frames > 0;
  Marker marker;
  marker.header.frame_id = on_the_way ? base_frame : map_frame;
  marker.ns = "status";
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.action = Marker::ADD;
  marker.frame_locked = static_cast<unsigned char>(on_the_way);
  marker.pose.position.z = on_the_way ? kOverVehicle : kTextHeight;
  marker.pose.orientation.w = 1.0;
  marker.scale.z = kTextHeight;
  marker.text = headline(status);
  if (on_the_way) marker.text += "\n" + figures(status);
  marker.color = color_of(status);
  return marker;
}

}  // namespace lidar_mapping::ros_border
