// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/ros/key_frame_feed.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/pose_feed.hpp"

namespace lidar_mapping::ros_border {

/// State of the run in the back end.
struct RunState {
  std::string run_id;                ///< empty if no run has begun
  std::vector<KeyFrame> key_frames;  ///< by index, without clouds
  KeyFramePoses poses;               ///< of all key frames
  std::vector<Loop> loops;           ///< all of the run, also those that the graph refuses
  std::vector<GnssPosition> gnss;    ///< at stamps of key frames
  std::vector<Floor> floors;         ///< below key frames
  KeyFrameIndex searched = 0;        ///< loop closing is done with the key frames below this index

  /// The run and the indices of its key frames.
  RunIndices indices() const;
};

/// Asks the back end through its service get_key_frames. Calls wait for the answer: they belong
/// into a worker, not into a callback.
class KeyFrameClient {
 public:
  /// The service is looked up in the namespace of `node`.
  explicit KeyFrameClient(const ros::NodeHandle& node);

  /// The present state of the back end; empty if there is no back end. Throws InputError for an
  /// inconsistent answer.
  std::optional<RunState> run();
  /// As run(); waits for a back end that reads a session to go on with, and up to 15 s for one that
  /// was killed during a drive and is being restarted.
  std::optional<RunState> wait_for_run();
  /// The present poses of all key frames, without the key frames themselves; empty if there is no
  /// back end or no run. Throws InputError for an inconsistent answer.
  std::optional<RunPoses> poses();
  /// These key frames with their clouds; empty if there is no back end.
  std::vector<ReceivedKeyFrame> fetch(const std::vector<KeyFrameIndex>& indices);

 private:
  std::optional<GetKeyFrames::Response> call(const std::vector<KeyFrameIndex>& indices,
                                             bool clouds);
  ros::NodeHandle node_;
};

/// Subscription of the topic key_frame without gaps: a KeyFrameFeed in the worker that fetches
/// missing key frames from the back end, at the start and whenever there is a gap.
class KeyFrameSubscription {
 public:
  /// Up to `capacity` messages may wait. `deliver` is called in the worker's thread.
  KeyFrameSubscription(NodeContext& context, int capacity, KeyFrameFeed::Deliver deliver);

  /// Fetches the key frames of `known` that this node has not received; all that exist if `known`
  /// is a part that leaves out some. It is called in the worker's thread with the indices of
  /// key_frame_poses.
  void note(RunIndices known);
  /// State of the delivery; for the worker's thread.
  const KeyFrameFeed& feed() const { return feed_; }

 private:
  void catch_up();

  KeyFrameClient client_;
  KeyFrameFeed feed_;
  ros::Subscriber subscriber_;
};

}  // namespace lidar_mapping::ros_border
