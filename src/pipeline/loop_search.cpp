// SPDX-License-Identifier: BSD-3-Clause
#include "loop_search.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "lidar_mapping/pipeline/session_part.hpp"

namespace lidar_mapping::pipeline {

void LoopSearch::process(DriveChunk& chunk) {
  chunk.loops = std::exchange(found_again_.loops, {});
  chunk.verdicts = std::exchange(found_again_.verdicts, {});
  if (!chunk.key_frame) return;
  if (chunk.p_base_lidar) closer_.set_sensor_origin(*chunk.p_base_lidar);
  if (const auto moved = feedback_.wait_for_step()) closer_.update_poses(*moved);
  for (const ScanEntry& scan : chunk.scans) {
    if (scan.gnss) closer_.add_gnss(*scan.gnss);
  }
  loop_closing::LoopClosingResult result = closer_.process(*chunk.key_frame, chunk.prepared);
  chunk.prepared = {};
  chunk.loops.insert(chunk.loops.end(), result.loops.begin(), result.loops.end());
  chunk.verdicts.insert(chunk.verdicts.end(), result.verdicts.begin(), result.verdicts.end());
}

void LoopSearch::restore(const RecordedBackEnd& back_end) {
  const session::Session& session = back_end.session();
  if (const auto origin = session.sensor_origin()) closer_.set_sensor_origin(*origin);
  const std::vector<KeyFrame> key_frames = session.key_frames();
  const auto first_open = std::find_if(
      key_frames.begin(), key_frames.end(),
      [end = back_end.searched_key_frames()](const auto& k) { return k.index >= end; });
  // Each with its key frame: the search keeps only few that come long before theirs.
  const auto positions = by_stamp(session.gnss());
  const auto add_position = [&](const KeyFrame& key_frame) {
    const auto found = positions.find(key_frame.stamp);
    if (found != positions.end()) closer_.add_gnss(found->second);
  };
  std::for_each(key_frames.begin(), first_open, [&](const auto& k) {
    add_position(k);
    closer_.restore(k);
  });
  closer_.restore(session.loops(), {}, back_end.poses());
  std::for_each(first_open, key_frames.end(), [&](const auto& k) {
    add_position(k);
    search_again(back_end, k);
  });
}

/// A match that waited for others that agree with it is in no file. What the session has is not
/// added to it again.
void LoopSearch::search_again(const RecordedBackEnd& back_end, const KeyFrame& key_frame) {
  const loop_closing::LoopClosingResult result = closer_.process(key_frame);
  std::copy_if(result.loops.begin(), result.loops.end(), std::back_inserter(found_again_.loops),
               [&](const Loop& loop) { return !back_end.has_loop(loop); });
  found_again_.verdicts.insert(found_again_.verdicts.end(), result.verdicts.begin(),
                               result.verdicts.end());
}

}  // namespace lidar_mapping::pipeline
