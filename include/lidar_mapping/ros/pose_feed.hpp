// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "lidar_mapping/ros/key_frame_feed.hpp"

namespace lidar_mapping::ros_border {

/// Poses of key frames, and the run that they belong to.
struct RunPoses {
  std::string run_id;   ///< names the run
  KeyFramePoses poses;  ///< of all key frames, or a part

  /// The run and the indices of the key frames.
  RunIndices indices() const;
};

/// Puts together the messages of key_frame_poses, of which most are parts. If a message is missing
/// before a part, because this node came late or the transport lost it, all poses are fetched.
/// Parts that are older than what was fetched are left out, because newer poses would be lost. One
/// thread calls it.
class PoseFeed {
 public:
  /// Returns all poses that the back end has at present; empty if there is no answer.
  using Fetch = std::function<std::optional<RunPoses>()>;

  /// Nothing is known at first; `fetch` is called in push().
  explicit PoseFeed(Fetch fetch);

  /// Takes poses. Returns what has changed by them: all poses, or the received part; nothing if
  /// that is outdated. Poses of another run begin that run. Where all poses are needed but there is
  /// no answer, the part is taken, and the next one asks again.
  std::optional<RunPoses> push(const RunPoses& received);
  /// All poses of that run as far as they are known, with the newest revision.
  KeyFramePoses known(const std::string& run_id) const;

 private:
  bool continues(const RunPoses& received) const;
  std::optional<RunPoses> fetched_instead_of(const RunPoses& received) const;
  void take(const RunPoses& news);

  Fetch fetch_;
  std::string run_id_;
  bool complete_ = false;  ///< no pose of the run is missing up to `revision_`
  std::uint32_t revision_ = 0;
  std::map<KeyFrameIndex, KeyFramePose> poses_;
};

}  // namespace lidar_mapping::ros_border
