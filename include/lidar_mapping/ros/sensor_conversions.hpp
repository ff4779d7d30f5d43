// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"
#include "lidar_mapping/ros/messages.hpp"

namespace lidar_mapping::ros_border {

/// A sample in the axes of the message's frame. Quantities with -1 in the first element of their
/// covariance are not provided (sensor_msgs/Imu); neither is an orientation whose quaternion is
/// zero.
ImuSample from_message(const sensor_msgs::Imu& message);
/// A sample in the axes of `frame_id`; covariances are 0 (unknown), or -1 for what is not provided.
sensor_msgs::Imu to_message(const ImuSample& sample, const std::string& frame_id);

/// A velocity (m/s, rad/s) in the axes of the message's frame.
VelocitySample from_message(const geometry_msgs::TwistStamped& message);
/// A velocity (m/s, rad/s) of `frame_id` in its axes.
geometry_msgs::TwistStamped to_message(const VelocitySample& sample, const std::string& frame_id);

/// A fix; it has no covariance if that is of unknown type.
GnssFix from_message(const sensor_msgs::NavSatFix& message);
/// A fix of the antenna `frame_id`.
sensor_msgs::NavSatFix to_message(const GnssFix& fix, const std::string& frame_id);

/// synced_gnss: position of the antenna (child_frame_id) in East-North-Up (frame_id), its 3x3
/// covariance, and the orientation of base_link in East-North-Up. Where that is not known the
/// orientation is the identity and pose.covariance[21] (roll, roll) is -1.
nav_msgs::Odometry to_message(const GnssPosition& position, const std::string& map_frame,
                              const std::string& antenna_frame);
/// The inverse. `p_base_antenna` is the lever arm (m) that tf gives for the message's
/// child_frame_id.
GnssPosition from_message(const nav_msgs::Odometry& message, const Eigen::Vector3d& p_base_antenna);

/// Writes the rotation that was removed from the scan by the gyro into synced_inputs, bit for bit.
void fill(SyncedInputsMessage& message, const UnevenTurning& turning);
/// Writes the mean specific force before the scan into synced_inputs, bit for bit.
void fill(SyncedInputsMessage& message, const FeltForce& felt);
/// The rotation that was removed from the scan by the gyro; empty if the message has none.
std::optional<UnevenTurning> uneven_turning_of(const SyncedInputsMessage& message);
/// The mean specific force before the scan; empty if the message has none.
std::optional<FeltForce> felt_force_of(const SyncedInputsMessage& message);
/// The fingerprint of the points as the driver sent them; empty if it is unknown.
std::optional<std::uint64_t> fingerprint_of(const SyncedInputsMessage& message);

}  // namespace lidar_mapping::ros_border
