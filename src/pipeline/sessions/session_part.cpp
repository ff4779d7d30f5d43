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
  for (const auto& scan : session.odometry()) stamps.insert(scan.stamp + offset);
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

namespace {

/// Copies the records of scans with a stamp, and of loops between key frames, that are to be kept,
/// with the offsets.
template <typename KeepsScan, typename KeepsLoop>
void copy_records_if(const KeepsScan& keeps_scan, const KeepsLoop& keeps_loop,
                     const session::Session& from, const PartOffsets& offsets,
                     session::Session& to) {
  session::Session::Batch batch(to);
  for (session::ScanRecord scan : from.scans()) {
    scan.stamp += offsets.stamp;
    if (keeps_scan(scan.stamp)) to.add_scan(scan);
  }
  for (session::ScanOdometry scan : from.odometry()) {
    scan.stamp += offsets.stamp;
    scan.drive += offsets.segment;
    if (keeps_scan(scan.stamp)) to.add_odometry(scan);
  }
  for (const LoopVerdict& own : from.verdicts()) {
    const LoopVerdict verdict = with_offsets(own, offsets);
    if (keeps_loop(verdict.from, verdict.to)) to.add_verdict(verdict);
  }
  batch.commit();
}

/// Stamps of the first and the last key frame of each segment.
std::map<std::uint32_t, std::pair<Stamp, Stamp>> spans_of(const std::vector<KeyFrame>& key_frames) {
  std::map<std::uint32_t, std::pair<Stamp, Stamp>> spans;
  for (const KeyFrame& key_frame : key_frames) {
    const Stamp stamp = key_frame.stamp;
    auto& [first, last] = spans.try_emplace(key_frame.segment, stamp, stamp).first->second;
    first = std::min(first, stamp);
    last = std::max(last, stamp);
  }
  return spans;
}

}  // namespace

void copy_records(const session::Session& from, const PartOffsets& offsets, session::Session& to) {
  copy_records_if([](Stamp /*stamp*/) { return true; },
                  [](KeyFrameIndex /*from*/, KeyFrameIndex /*to*/) { return true; }, from, offsets,
                  to);
}

void copy_records(const session::Session& from, const std::vector<KeyFrame>& key_frames,
                  const PartOffsets& offsets, session::Session& to) {
  const auto spans = spans_of(key_frames);
  std::set<KeyFrameIndex> kept;
  for (const KeyFrame& key_frame : key_frames) kept.insert(key_frame.index);
  copy_records_if(
      [&](Stamp stamp) {
        return std::any_of(spans.begin(), spans.end(), [&](const auto& segment) {
          return segment.second.first <= stamp && stamp <= segment.second.second;
        });
      },
      [&](KeyFrameIndex a, KeyFrameIndex b) { return kept.count(a) > 0 && kept.count(b) > 0; },
      from, offsets, to);
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
