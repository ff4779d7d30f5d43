// SPDX-License-Identifier: BSD-3-Clause
#include "loop_search.hpp"

namespace lidar_mapping::pipeline {

void LoopSearch::process(DriveChunk& chunk) {
  if (!chunk.key_frame) return;
  if (chunk.p_base_lidar) closer_.set_sensor_origin(*chunk.p_base_lidar);
  if (const auto moved = feedback_.wait_for_step()) closer_.update_poses(*moved);
  for (const ScanEntry& scan : chunk.scans) {
    if (scan.gnss) closer_.add_gnss(*scan.gnss);
  }
  loop_closing::LoopClosingResult result = closer_.process(*chunk.key_frame, chunk.prepared);
  chunk.prepared = {};
  chunk.loops = std::move(result.loops);
  chunk.verdicts = std::move(result.verdicts);
}

void LoopSearch::restore(const RecordedBackEnd& back_end) {
  const session::Session& session = back_end.session();
  if (const auto origin = session.sensor_origin()) closer_.set_sensor_origin(*origin);
  for (const KeyFrame& key_frame : session.key_frames()) closer_.restore(key_frame);
  closer_.restore(session.loops(), session.gnss(), back_end.poses());
}

}  // namespace lidar_mapping::pipeline
