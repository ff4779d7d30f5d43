// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/recorded_frames.hpp"

#include <stdexcept>

#include <tf2/exceptions.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bags/wire_array.hpp"

namespace lidar_mapping::ros_border {

std::optional<tf2_msgs::TFMessage> read_transforms(const BagMessage& recorded) {
  if (!recorded.is<tf2_msgs::TFMessage>()) return std::nullopt;
  // Bytes of the shortest, by the format of geometry_msgs/TransformStamped: two empty names, number
  // and stamp, translation and rotation.
  constexpr std::uint32_t kShortest = 4 + 8 + 4 + 4 + 7 * 8;
  ros::serialization::IStream stream = recorded.stream();
  array_length(stream, kShortest);
  return recorded.instantiate<tf2_msgs::TFMessage>();
}

void RecordedFrames::add(const tf2_msgs::TFMessage& message, bool is_static) {
  for (geometry_msgs::TransformStamped transform : message.transforms) {
    transform.header.frame_id = frame_name(transform.header.frame_id);
    transform.child_frame_id = frame_name(transform.child_frame_id);
    try {
      frames_.setTransform(transform, "recording", is_static);
    } catch (const std::runtime_error&) {
      // tf2 adds to the stamp how long it keeps transforms. A damaged one that leaves no room for
      // that is left out.
    }
  }
}

std::optional<Pose> RecordedFrames::T_base(const std::string& frame) const {
  return look_up(frame, ros::Time(0));
}

std::optional<Pose> RecordedFrames::T_base(const std::string& frame, Stamp stamp) const {
  return look_up(frame, to_ros(stamp));
}

std::optional<Pose> RecordedFrames::look_up(const std::string& frame, const ros::Time& time) const {
  if (frame == base_frame_) return Pose::Identity();
  try {
    return from_message(frames_.lookupTransform(base_frame_, frame, time).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace lidar_mapping::ros_border
