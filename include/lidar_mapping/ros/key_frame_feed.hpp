// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::ros_border {

/// Indices of the key frames of a run that exist, or some of them.
struct RunIndices {
  std::string run_id;                  ///< names the run
  std::vector<KeyFrameIndex> indices;  ///< increasing
  bool whole = true;                   ///< there are no others
};

/// A key frame as its message has it.
struct ReceivedKeyFrame : RunKeyFrame {
  /// Place of the LiDAR on the vehicle, m in base_link; empty: not known.
  std::optional<Eigen::Vector3d> p_base_lidar;
};

/// Delivers every key frame of a run once, in the order of the indices: those that arrive, and
/// those that this node missed because it was started late, was restarted, or lost messages in
/// transport. Missing key frames are requested; one that is not received before five newer ones
/// have arrived is skipped and counted. A key frame of another run begins that run, behind those of
/// the run before that still waited. One thread calls it.
class KeyFrameFeed {
 public:
  /// Returns the known ones of the key frames with these indices; empty if there is no answer.
  using Fetch =
      std::function<std::vector<ReceivedKeyFrame>(const std::vector<KeyFrameIndex>& indices)>;
  /// Receives a delivered key frame.
  using Deliver = std::function<void(const ReceivedKeyFrame&)>;
  /// Called when a run begins; returns the index of its first key frame that is to be delivered.
  using Begin = std::function<KeyFrameIndex(const std::string& run_id)>;

  /// Without `begin` every run is delivered from index 0.
  KeyFrameFeed(
      Fetch fetch, Deliver deliver, Begin begin = [](const std::string&) { return 0U; });

  /// Adds a received key frame.
  void push(ReceivedKeyFrame key_frame);
  /// Fetches and delivers those of the existing key frames that were not yet delivered.
  void catch_up(const RunIndices& known);
  /// Whether catch_up() would skip key frames that may exist: `some`, which is not whole, leaves
  /// out some of those between the newest delivered one and its last.
  bool would_skip(const RunIndices& some) const;
  /// Skips missing key frames and delivers those after them.
  void flush();

  /// The run whose key frames are delivered; empty before the first.
  const std::string& run_id() const { return run_id_; }
  /// One more than the newest delivered index.
  KeyFrameIndex next_index() const { return next_; }
  /// Number of skipped key frames.
  std::size_t missing() const { return missing_; }

 private:
  void begin_run(const std::string& run_id);
  void fetch(const std::vector<KeyFrameIndex>& indices);
  void fetch_gap();
  void skip_missing();
  void deliver_pending();
  void deliver_first();

  Fetch fetch_;
  Deliver deliver_;
  Begin begin_;
  std::string run_id_;
  KeyFrameIndex next_ = 0;
  std::map<KeyFrameIndex, ReceivedKeyFrame> pending_;
  std::size_t missing_ = 0;
};

}  // namespace lidar_mapping::ros_border
