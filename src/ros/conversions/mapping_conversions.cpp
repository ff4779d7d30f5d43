// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/mapping_conversions.hpp"

#include <algorithm>
#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Of a LiDAR, in a message, which has no empty fields.
const Eigen::Vector3d kUnknownPlace =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

std::vector<geometry_msgs::Vector3> to_messages(const std::vector<Eigen::Vector3d>& vectors) {
  std::vector<geometry_msgs::Vector3> messages;
  messages.reserve(vectors.size());
  for (const Eigen::Vector3d& vector : vectors) messages.push_back(to_message(vector));
  return messages;
}

Covariance6 checked_covariance(const CovarianceArray& values, const std::string& what) {
  const Covariance6 covariance = from_array(values);
  if (!covariance.allFinite()) throw InputError(what + ": the covariance is not finite");
  return covariance;
}

/// Copies what a verdict and its message have alike.
template <typename From, typename To>
void copy_figures(const From& from, To& to) {
  to.from = from.from;
  to.to = from.to;
  to.reason = from.reason;
  to.distance = from.distance;
  to.fitness = from.fitness;
  to.overlap = from.overlap;
  to.free_space_violation = from.free_space_violation;
  to.horizontal_eigenvalue = from.horizontal_eigenvalue;
  to.innovation = from.innovation;
}

}  // namespace

KeyFrameMessage to_message(const KeyFrame& key_frame, const std::string& run_id,
                           const std::string& base_frame,
                           const std::optional<Eigen::Vector3d>& p_base_lidar) {
  KeyFrameMessage message;
  message.header = header_of(key_frame.stamp, base_frame);
  message.run_id = run_id;
  message.index = key_frame.index;
  message.segment = key_frame.segment;
  message.odometry_pose = to_message(key_frame.T_odom_base);
  message.motion_covariance = to_array(key_frame.motion_covariance);
  message.degenerate_directions = to_messages(key_frame.degenerate_directions);
  message.doubtful = key_frame.doubtful;
  message.lidar_origin = to_message(p_base_lidar.value_or(kUnknownPlace));
  if (key_frame.cloud) message.cloud = to_message(*key_frame.cloud, key_frame.stamp, base_frame);
  return message;
}

KeyFrame from_message(const KeyFrameMessage& message) {
  KeyFrame key_frame;
  key_frame.index = message.index;
  key_frame.segment = message.segment;
  key_frame.stamp = from_ros(message.header.stamp);
  key_frame.T_odom_base = from_message(message.odometry_pose);
  key_frame.motion_covariance = checked_covariance(message.motion_covariance, "key_frame");
  for (const auto& direction : message.degenerate_directions) {
    key_frame.degenerate_directions.push_back(from_message(direction));
  }
  key_frame.doubtful = message.doubtful;
  if (!message.cloud.fields.empty()) {
    key_frame.cloud = std::make_shared<PointCloud>(from_message(message.cloud));
  }
  return key_frame;
}

ReceivedKeyFrame received(const KeyFrameMessage& message) {
  ReceivedKeyFrame result{{message.run_id, from_message(message)}, std::nullopt};
  const Eigen::Vector3d origin = from_message(message.lidar_origin);
  if (origin.allFinite()) result.p_base_lidar = origin;
  return result;
}

KeyFramePosesMessage to_message(const KeyFramePoses& poses, const std::string& run_id,
                                const std::string& map_frame) {
  KeyFramePosesMessage message;
  message.header = header_of(poses.poses.empty() ? 0 : poses.poses.back().stamp, map_frame);
  message.run_id = run_id;
  message.revision = poses.revision;
  message.since = poses.since;
  message.whole = poses.whole;
  for (const KeyFramePose& pose : poses.poses) {
    message.indices.push_back(pose.index);
    message.stamps.push_back(to_ros(pose.stamp));
    message.poses.push_back(to_message(pose.T_map_base));
  }
  return message;
}

KeyFramePoses from_message(const KeyFramePosesMessage& message) {
  const std::size_t count = message.indices.size();
  if (message.stamps.size() != count || message.poses.size() != count) {
    throw InputError("key_frame_poses: indices, stamps and poses differ in number");
  }
  KeyFramePoses result{message.revision, message.whole != 0, {}, message.since};
  result.poses.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    result.poses.push_back(
        {message.indices[i], from_ros(message.stamps[i]), from_message(message.poses[i])});
  }
  return result;
}

LoopMessage to_message(const Loop& loop, const std::string& run_id, const std::string& base_frame) {
  LoopMessage message;
  message.header = header_of(loop.stamp, base_frame);
  message.run_id = run_id;
  message.from = loop.from;
  message.to = loop.to;
  message.pose = to_message(loop.T_from_to);
  message.covariance = to_array(loop.covariance);
  message.fitness = loop.fitness;
  message.overlap = loop.overlap;
  message.source = to_string(loop.source);
  return message;
}

Loop from_message(const LoopMessage& message) {
  Loop loop;
  loop.from = message.from;
  loop.to = message.to;
  loop.stamp = from_ros(message.header.stamp);
  loop.T_from_to = from_message(message.pose);
  loop.covariance = checked_covariance(message.covariance, "loop");
  loop.fitness = message.fitness;
  loop.overlap = message.overlap;
  loop.source = loop_source_from(message.source);
  return loop;
}

LoopVerdictMessage to_message(const LoopVerdict& verdict, const std::string& run_id,
                              const std::string& base_frame) {
  LoopVerdictMessage message;
  message.header = header_of(verdict.stamp, base_frame);
  message.run_id = run_id;
  message.source = to_string(verdict.source);
  message.verdict = to_string(verdict.verdict);
  copy_figures(verdict, message);
  return message;
}

LoopVerdict from_message(const LoopVerdictMessage& message) {
  LoopVerdict verdict;
  verdict.stamp = from_ros(message.header.stamp);
  verdict.source = loop_source_from(message.source);
  verdict.verdict = verdict_from(message.verdict);
  copy_figures(message, verdict);
  return verdict;
}

FloorMessage to_message(const Floor& floor, const std::string& base_frame) {
  FloorMessage message;
  message.header = header_of(floor.stamp, base_frame);
  message.found = floor.found;
  std::copy_n(floor.normal.data(), 3, message.plane.begin());
  message.plane[3] = floor.offset;
  const Eigen::Matrix3d covariance = 0.5 * (floor.covariance + floor.covariance.transpose());
  std::copy_n(covariance.data(), 9, message.covariance.begin());
  message.inliers = static_cast<std::uint32_t>(std::max(0, floor.inliers));
  return message;
}

Floor from_message(const FloorMessage& message) {
  Floor floor;
  floor.stamp = from_ros(message.header.stamp);
  floor.found = message.found != 0;
  std::copy_n(message.plane.begin(), 3, floor.normal.data());
  floor.offset = message.plane[3];
  std::copy_n(message.covariance.begin(), 9, floor.covariance.data());
  floor.inliers = static_cast<int>(message.inliers);
  return floor;
}

FrontEndStatusMessage to_message(const front_end::FrontEndResult& result,
                                 std::uint32_t scans_dropped, const std::string& base_frame) {
  const front_end::FrontEndStatus& status = result.status;
  FrontEndStatusMessage message;
  message.header = header_of(result.stamp, base_frame);
  message.state = to_string(status.state);
  message.probability = status.probability;
  message.converged = status.converged;
  message.iterations = static_cast<std::uint32_t>(std::max(0, status.iterations));
  message.fitness = status.fitness;
  message.inlier_fraction = status.inlier_fraction;
  message.overlap = status.overlap;
  message.degenerate_directions = to_messages(status.degenerate_directions);
  message.rescued = status.rescued;
  message.repeated = status.repeated;
  message.elevation_shift = status.elevation_shift;
  message.stamp_jitter = status.stamp_jitter;
  message.sweep_times = to_string(status.sweep_times.source);
  message.gyro_distrusted = status.gyro_distrusted;
  message.velocity_distrusted = status.velocity_distrusted;
  message.vertical_ride_distance = status.vertical_ride_distance;
  message.unobserved_stddev = status.unobserved_stddev;
  message.key_frame = result.key_frame.has_value();
  if (result.key_frame) message.key_frame_index = result.key_frame->index;
  message.scans_dropped = scans_dropped;
  message.seconds = status.seconds;
  for (const auto& [name, seconds] : status.step_seconds) {
    message.step_names.push_back(name);
    message.step_seconds.push_back(seconds);
  }
  return message;
}

nav_msgs::Odometry to_odometry(const front_end::FrontEndResult& result,
                               const Covariance6& covariance, double seconds,
                               const std::string& odom_frame, const std::string& base_frame) {
  nav_msgs::Odometry message;
  message.header = header_of(result.stamp, odom_frame);
  message.child_frame_id = base_frame;
  message.pose.pose = to_message(result.T_odom_base);
  message.pose.covariance = to_array(in_parent_axes(covariance, result.T_odom_base));
  message.twist.twist = to_twist(result.twist);
  if (seconds > 0.0) {
    message.twist.covariance = to_array(result.covariance / (seconds * seconds));
  }
  return message;
}

}  // namespace lidar_mapping::ros_border
