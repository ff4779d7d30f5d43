// SPDX-License-Identifier: BSD-3-Clause
#include "loop_search.hpp"

namespace lidar_mapping::pipeline {

void LoopSearch::process(DrivePiece& piece) {
  if (!piece.key_frame) return;
  if (piece.p_base_lidar) closer_.set_sensor_origin(*piece.p_base_lidar);
  if (const auto moved = feedback_.take()) closer_.update_poses(*moved);
  for (const ScanEntry& scan : piece.scans) {
    if (scan.gnss) closer_.add_gnss(*scan.gnss);
  }
  loop_closing::LoopClosingResult result = closer_.process(*piece.key_frame, piece.prepared);
  piece.prepared = {};
  piece.loops = std::move(result.loops);
  piece.verdicts = std::move(result.verdicts);
}

void LoopSearch::restore(const RecordedBackEnd& run) {
  const session::Session& session = run.session();
  if (const auto origin = session.sensor_origin()) closer_.set_sensor_origin(*origin);
  for (const KeyFrame& key_frame : session.key_frames()) closer_.restore(key_frame);
  closer_.restore(session.loops(), session.gnss(), run.poses());
}

}  // namespace lidar_mapping::pipeline
