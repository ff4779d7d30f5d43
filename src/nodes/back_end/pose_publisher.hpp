// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::ros_border {

/// Publishes key_frame_poses: what is new or has moved to all subscribers (SentPoses), and all
/// poses as they were sent to each new subscriber alone. So every subscriber has an unbroken
/// sequence that begins with all poses. Any thread may call it.
class PosePublisher {
 public:
  /// Advertises the topic. `map_frame` is the frame of the poses.
  PosePublisher(ros::NodeHandle& node, const std::string& map_frame);

  /// Begins a run, of which new subscribers are sent nothing until the first publish().
  void begin_run(const std::string& run_id);
  /// Sends what has changed of `poses`, which are all of the run; all of them if `thorough`: the
  /// answer to optimize_map. False if nothing had to be sent.
  bool publish(const KeyFramePoses& poses, bool thorough);

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared with the greeting of new subscribers
  ros::Publisher publisher_;
};

}  // namespace lidar_mapping::ros_border
