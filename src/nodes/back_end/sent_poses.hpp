// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::ros_border {

/// The poses of a run as the subscribers of key_frame_poses know them, and what they have to be
/// sent: the key frames that are new, and those that moved since their pose was last sent. So the
/// messages do not grow with the drive, and moves that are too small to be sent do not add up. All
/// poses are compared each time, which takes far less than their solution. One thread calls it.
class SentPoses {
 public:
  /// Begins another run, of which nothing has been sent.
  void clear() { sent_ = {}; }
  /// Takes all poses. Returns what has to be sent, which counts as sent: the new and moved ones;
  /// all of them at first, if all have moved, or if `whole` is set. Nothing if no pose has to be
  /// sent.
  std::optional<KeyFramePoses> update(const KeyFramePoses& now, bool whole);
  /// All poses as they were sent, for a new subscriber; none before the first update().
  const KeyFramePoses& all() const { return sent_; }

 private:
  bool is_continued_by(const KeyFramePoses& now) const;
  KeyFramePoses take_changes(const KeyFramePoses& now);

  KeyFramePoses sent_;
};

}  // namespace lidar_mapping::ros_border
