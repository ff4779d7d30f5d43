// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/ros/bag_stream.hpp"

namespace lidar_mapping::ros_border {

/// The transforms in a message of /tf or /tf_static; empty if it is of another type. Throws
/// ros::Exception if it is damaged.
std::optional<tf2_msgs::TFMessage> read_transforms(const BagMessage& recorded);

/// The tree of the transforms of a recording.
class RecordedFrames {
 public:
  /// `base_frame` stands for the vehicle.
  explicit RecordedFrames(std::string base_frame) : base_frame_(std::move(base_frame)) {}

  /// The frame that stands for the vehicle.
  const std::string& base_frame() const { return base_frame_; }
  /// Uses this frame for the vehicle from now on.
  void set_base_frame(std::string frame) { base_frame_ = std::move(frame); }

  /// Adds a message of /tf_static (`is_static`) or /tf. Rotations whose quaternion was rounded are
  /// brought to length 1; transforms that are not finite or no rotation are left out, and those of
  /// /tf that are published twice.
  void add(const tf2_msgs::TFMessage& message, bool is_static);
  /// What is wrong with the first transform that was left out, with its frames; empty without one.
  const std::string& problem() const { return problem_; }
  /// The pose of a frame on the vehicle at a time, interpolated; 0 stands for the newest pose, as
  /// in tf. Nothing if no chain of transforms leads there, or they do not reach that time.
  std::optional<Pose> T_base(const std::string& frame, Stamp stamp = 0) const;

 private:
  bool is_repeated(const geometry_msgs::TransformStamped& transform);

  std::string base_frame_;
  std::string problem_;
  std::map<std::string, ros::Time> newest_;  ///< of /tf, stamps by the child's name
  tf2::BufferCore frames_{ros::Duration(1e6)};
};

}  // namespace lidar_mapping::ros_border
