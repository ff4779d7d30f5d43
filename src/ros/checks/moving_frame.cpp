// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/moving_frame.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace lidar_mapping::ros_border {

namespace {

constexpr Stamp kBegin = std::numeric_limits<Stamp>::min();
constexpr Stamp kEnd = std::numeric_limits<Stamp>::max();
constexpr int kTimes = 10;         // of a recording; chosen: a vehicle stands at few of them
constexpr double kWindow = 1.0;    // s; chosen: all transforms of a tree come within it
constexpr double kDistance = 1.0;  // m; chosen: arms and gimbals move a sensor by less

/// Where the vehicle is in a frame by the transforms of a window.
std::optional<Eigen::Vector3d> position_in(const BagSet& bags, const std::string& base_frame,
                                           const std::string& frame, Stamp from) {
  RecordedFrames frames(base_frame);
  add_recorded_frames(bags, "/tf_static", kBegin, kEnd, frames);
  add_recorded_frames(bags, "/tf", from, from + from_seconds(kWindow), frames);
  const auto T_base_frame = frames.T_base(frame);
  if (!T_base_frame) return std::nullopt;
  return T_base_frame->inverse().translation;
}

bool is_fixed(const BagSet& bags, const std::string& base_frame, const std::string& frame) {
  RecordedFrames frames(base_frame);
  add_recorded_frames(bags, "/tf_static", kBegin, kEnd, frames);
  return frames.T_base(frame).has_value();
}

}  // namespace

void add_recorded_frames(const BagSet& bags, const std::string& topic, Stamp from, Stamp until,
                         RecordedFrames& frames) {
  BagStream messages = bags.messages_of({topic});
  messages.skip_to(from);
  for (auto message = messages.next(); message && message->recorded <= until;
       message = messages.next()) {
    try {
      const auto transforms = read_transforms(*message);
      if (transforms) frames.add(*transforms, topic == "/tf_static");
    } catch (const ros::Exception&) {
      continue;
    }
  }
}

bool vehicle_moves_in(const BagSet& bags, const std::string& base_frame, const std::string& frame) {
  const auto times = bags.times_of({"/tf"});
  if (frame.empty() || !times || is_fixed(bags, base_frame, frame)) return false;
  const Stamp step = (times->second - times->first) / kTimes;
  std::optional<Eigen::Vector3d> first;
  for (int i = 0; i < kTimes; ++i) {
    const auto position = position_in(bags, base_frame, frame, times->first + i * step);
    if (!position) continue;
    if (!first) first = position;
    if ((*position - *first).norm() > kDistance) return true;
  }
  return false;
}

}  // namespace lidar_mapping::ros_border
