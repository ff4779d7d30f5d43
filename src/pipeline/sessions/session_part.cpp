// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_part.hpp"

#include <algorithm>

#include "lidar_mapping/pipeline/datum.hpp"

namespace lidar_mapping::pipeline {

PartOffsets offsets_behind(const std::vector<KeyFrame>& key_frames) {
  PartOffsets offsets;
  if (key_frames.empty()) return offsets;
  offsets.index = key_frames.back().index + 1;
  offsets.segment = key_frames.back().segment + 1;
  return offsets;
}

std::set<Stamp> stamps_of(const session::Session& session, Stamp offset) {
  std::set<Stamp> stamps;
  for (const KeyFrame& key_frame : session.key_frames()) stamps.insert(key_frame.stamp + offset);
  for (const session::ScanRecord& scan : session.scans()) stamps.insert(scan.stamp + offset);
  for (const auto& [stamp, pose] : session.odometry()) stamps.insert(stamp + offset);
  return stamps;
}

Stamp unique_stamp_offset(const std::set<Stamp>& stamps, const std::set<Stamp>& known) {
  Stamp offset = 0;
  const auto is_known = [&](Stamp stamp) { return known.count(stamp + offset) > 0; };
  while (std::any_of(stamps.begin(), stamps.end(), is_known)) ++offset;
  return offset;
}

SessionPart read_part(const session::Session& session, const PartOffsets& offsets,
                      const std::vector<GnssPosition>& gnss) {
  SessionPart part;
  part.key_frames = session.key_frames();
  for (KeyFrame& key_frame : part.key_frames) {
    key_frame.index += offsets.index;
    key_frame.segment += offsets.segment;
    key_frame.stamp += offsets.stamp;
  }
  part.gnss = by_stamp(gnss, offsets.stamp);
  part.imu = by_stamp(session.imu(), offsets.stamp);
  part.floors = by_stamp(session.floors(), offsets.stamp);
  for (const Loop& own : session.loops()) {
    const Loop loop = with_offsets(own, offsets);
    part.loops.emplace(std::max(loop.from, loop.to), loop);
  }
  return part;
}

void copy_settings(const session::Session& from, session::Session& to) {
  for (const auto& [stage, yaml] : from.configurations()) to.set_configuration(stage, yaml);
  if (const auto origin = from.sensor_origin()) to.set_sensor_origin(*origin);
}

void copy_records(const session::Session& from, const PartOffsets& offsets, session::Session& to) {
  session::Session::Batch batch(to);
  for (session::ScanRecord scan : from.scans()) {
    scan.stamp += offsets.stamp;
    to.add_scan(scan);
  }
  for (const auto& [stamp, pose] : from.odometry()) to.add_odometry(stamp + offsets.stamp, pose);
  for (const LoopVerdict& verdict : from.verdicts()) {
    to.add_verdict(with_offsets(verdict, offsets));
  }
  batch.commit();
}

std::vector<GnssPosition> gnss_in_frame_of(const std::optional<GeodeticDatum>& datum,
                                           const session::Session& session) {
  const auto own = session.datum();
  if (!datum || !own) return {};
  std::vector<GnssPosition> positions = session.gnss();
  const Pose T_new_old = enu_between(*datum, *own);
  for (GnssPosition& position : positions) position = transformed_position(position, T_new_old);
  return positions;
}

}  // namespace lidar_mapping::pipeline
