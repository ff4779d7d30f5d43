// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/moving_frame.hpp"

#include <limits>
#include <optional>

namespace lidar_mapping::ros_border {

namespace {

constexpr Stamp kBegin = std::numeric_limits<Stamp>::min();
constexpr Stamp kEnd = std::numeric_limits<Stamp>::max();
constexpr int kTimes = 10;         // of a recording; chosen: a vehicle stands at few of them
constexpr double kWindow = 1.0;    // s; chosen: all transforms of a tree come within it
constexpr double kDistance = 1.0;  // m; chosen: arms and gimbals move a sensor by less

/// The pose of a frame on the vehicle by /tf_static, and by what is on /tf in a window.
std::optional<Pose> T_base(const BagSet& bags, const std::string& base_frame,
                           const std::string& frame, std::optional<Stamp> window) {
  RecordedFrames frames(base_frame);
  add_recorded_frames(bags, "/tf_static", kBegin, kEnd, frames);
  if (window) {
    add_recorded_frames(bags, "/tf", *window, *window + from_seconds(kWindow), frames);
  }
  return frames.T_base(frame);
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
  if (frame.empty() || !times || T_base(bags, base_frame, frame, std::nullopt)) return false;
  const Stamp step = (times->second - times->first) / kTimes;
  std::optional<Eigen::Vector3d> first;
  for (int i = 0; i < kTimes; ++i) {
    const auto T_base_frame = T_base(bags, base_frame, frame, times->first + i * step);
    if (!T_base_frame) continue;
    const Eigen::Vector3d position = T_base_frame->inverse().translation;
    if (!first) first = position;
    if ((position - *first).norm() > kDistance) return true;
  }
  return false;
}

}  // namespace lidar_mapping::ros_border
