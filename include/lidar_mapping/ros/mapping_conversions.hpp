// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <nav_msgs/Odometry.h>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/ros/key_frame_feed.hpp"
#include "lidar_mapping/ros/messages.hpp"

// This package's own messages <-> the values of its stages. Both directions keep all fields; the
// frame and the run's name, which values do not carry, are arguments. Inconsistent messages
// (indices that do not fit together, covariances that are not finite) throw InputError.
namespace lidar_mapping::ros_border {

/// A key frame with its cloud, if it has one, and the place of the LiDAR (m, in `base_frame`).
KeyFrameMessage to_message(const KeyFrame& key_frame, const std::string& run_id,
                           const std::string& base_frame,
                           const std::optional<Eigen::Vector3d>& p_base_lidar = std::nullopt);
/// A key frame; its cloud is null where the message has none.
KeyFrame from_message(const KeyFrameMessage& message);
/// All that the message has.
ReceivedKeyFrame received(const KeyFrameMessage& message);

/// Poses of key frames in `map_frame`.
KeyFramePosesMessage to_message(const KeyFramePoses& poses, const std::string& run_id,
                                const std::string& map_frame);
/// Poses of key frames. Throws InputError if the lists of the message differ in length.
KeyFramePoses from_message(const KeyFramePosesMessage& message);

/// A loop without the user's decision, which stays with the back end.
LoopMessage to_message(const Loop& loop, const std::string& run_id, const std::string& base_frame);
/// A loop without a decision of the user. Throws InputError for a source that is not known.
Loop from_message(const LoopMessage& message);

/// The decision about a candidate.
LoopVerdictMessage to_message(const LoopVerdict& verdict, const std::string& run_id,
                              const std::string& base_frame);
/// The decision about a candidate. Throws InputError for a source or a verdict that is not known.
LoopVerdict from_message(const LoopVerdictMessage& message);

/// A floor in `base_frame`.
FloorMessage to_message(const Floor& floor, const std::string& base_frame);
/// A floor in base_link.
Floor from_message(const FloorMessage& message);

/// The status and whether the scan became a key frame. `scans_dropped`: since the start of the run.
FrontEndStatusMessage to_message(const front_end::FrontEndResult& result,
                                 std::uint32_t scans_dropped, const std::string& base_frame);

/// Odometry at the result's stamp: pose in `odom_frame`, twist in `base_frame`. `covariance` is
/// that of T_odom_base (axes of base_link); the message has it in the axes of `odom_frame`, as its
/// definition wants. The twist's covariance follows from that of the last motion over `seconds`,
/// and is zero if that is 0.
nav_msgs::Odometry to_odometry(const front_end::FrontEndResult& result,
                               const Covariance6& covariance, double seconds,
                               const std::string& odom_frame, const std::string& base_frame);

}  // namespace lidar_mapping::ros_border
