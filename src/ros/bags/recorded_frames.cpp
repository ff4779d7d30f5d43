// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/recorded_frames.hpp"

#include <cmath>
#include <stdexcept>

#include <tf2/exceptions.h>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "bags/wire_array.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Of the length of a quaternion, whose rotation is believed. Chosen: numbers that were typed with
/// one decimal, such as 0.7 for the root of 1/2, are off by some per cent; tf2 believes half a one.
constexpr double kMaxLengthError = 0.1;

/// What is wrong with a transform that cannot be one; empty if it can.
std::string problem_of(const geometry_msgs::TransformStamped& stamped) {
  const geometry_msgs::Vector3& p = stamped.transform.translation;
  const geometry_msgs::Quaternion& q = stamped.transform.rotation;
  const bool is_finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (is_finite && std::abs(length - 1.0) < kMaxLengthError) return "";
  const std::string frames =
      "the transform from '" + stamped.header.frame_id + "' to '" + stamped.child_frame_id + "'";
  if (!is_finite) return frames + " has a translation that is not finite";
  return frames + formatted(" has the quaternion (%.3g, %.3g, %.3g, %.3g), whose length is not 1",
                            q.x, q.y, q.z, q.w);
}

void normalise(geometry_msgs::Quaternion& q) {
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  q.x /= length;
  q.y /= length;
  q.z /= length;
  q.w /= length;
}

}  // namespace

std::optional<tf2_msgs::TFMessage> read_transforms(const BagMessage& recorded) {
  if (!recorded.is<tf2_msgs::TFMessage>()) return std::nullopt;
  // Bytes of the shortest, by the format of geometry_msgs/TransformStamped: two empty names, number
  // and stamp, translation and rotation.
  constexpr std::uint32_t kShortest = 4 + 8 + 4 + 4 + 7 * 8;
  ros::serialization::IStream stream = stream_of(recorded.data);
  array_length(stream, kShortest);
  return recorded.instantiate<tf2_msgs::TFMessage>();
}

void RecordedFrames::add(const tf2_msgs::TFMessage& message, bool is_static) {
  for (geometry_msgs::TransformStamped transform : message.transforms) {
    transform.header.frame_id = frame_name(transform.header.frame_id);
    transform.child_frame_id = frame_name(transform.child_frame_id);
    const std::string problem = problem_of(transform);
    if (!problem.empty()) {
      if (problem_.empty()) problem_ = problem;
      continue;
    }
    normalise(transform.transform.rotation);
    if (!is_static && is_repeated(transform)) continue;
    try {
      frames_.setTransform(transform, "recording", is_static);
    } catch (const std::runtime_error&) {
      // tf2 adds to the stamp how long it keeps transforms. A damaged one that leaves no room for
      // that is left out.
    }
  }
}

/// tf2 prints a line for each of these, and two publishers of one transform make thousands.
bool RecordedFrames::is_repeated(const geometry_msgs::TransformStamped& transform) {
  const auto [newest, is_first] = newest_.emplace(transform.child_frame_id, transform.header.stamp);
  if (is_first) return false;
  const bool is_repeated = newest->second == transform.header.stamp;
  newest->second = transform.header.stamp;
  return is_repeated;
}

std::optional<Pose> RecordedFrames::T_base(const std::string& frame, Stamp stamp) const {
  const ros::Time time = to_ros(stamp);
  if (frame == base_frame_) return Pose::Identity();
  try {
    return from_message(frames_.lookupTransform(base_frame_, frame, time).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace lidar_mapping::ros_border
