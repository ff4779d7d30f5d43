// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::ros_border {

/// A key frame and the run that it belongs to.
struct RunKeyFrame {
  std::string run_id;  ///< names the run
  KeyFrame key_frame;  ///< with or without its cloud
};

/// Which key frames of which run exist.
struct RunIndices {
  std::string run_id;                  ///< names the run
  std::vector<KeyFrameIndex> indices;  ///< increasing
};

/// Hands on every key frame of a run once, in the order of the indices: those that arrive, and
/// those that this node missed, because it started late, was started again, or the transport lost
/// them. What is missing is asked for; when nobody has it while five more key frames have come, it
/// is given up and counted. A key frame of another run begins that run. One thread calls it.
class KeyFrameFeed {
 public:
  /// Key frames with these indices, those that are known; nothing if nobody answers.
  using Fetch = std::function<std::vector<RunKeyFrame>(const std::vector<KeyFrameIndex>& indices)>;
  /// Takes a key frame that is handed on.
  using Deliver = std::function<void(const RunKeyFrame&)>;
  /// A run begins; returns the index of its first key frame that is still to be handed on.
  using Begin = std::function<KeyFrameIndex(const std::string& run_id)>;

  /// Without `begin` every run is handed on from index 0.
  KeyFrameFeed(
      Fetch fetch, Deliver deliver, Begin begin = [](const std::string&) { return 0U; });

  /// A key frame has arrived.
  void push(RunKeyFrame key_frame);
  /// These key frames exist; fetches and hands on those that were not yet.
  void catch_up(const RunIndices& known);
  /// Gives up what is missing, and hands on what waits for it.
  void flush();

  /// The run whose key frames are handed on; empty before the first.
  const std::string& run_id() const { return run_id_; }
  /// One more than the newest index that was handed on.
  KeyFrameIndex next_index() const { return next_; }
  /// Key frames that were given up.
  std::size_t missing() const { return missing_; }

 private:
  void begin_run(const std::string& run_id);
  void fetch(const std::vector<KeyFrameIndex>& indices);
  void fetch_gap();
  void give_up_first();
  void deliver_pending();
  void deliver_first();

  Fetch fetch_;
  Deliver deliver_;
  Begin begin_;
  std::string run_id_;
  KeyFrameIndex next_ = 0;
  std::map<KeyFrameIndex, RunKeyFrame> pending_;
  std::size_t missing_ = 0;
};

}  // namespace lidar_mapping::ros_border
