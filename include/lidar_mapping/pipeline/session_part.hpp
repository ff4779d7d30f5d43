// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Offsets of a session in a graph of several, so that indices, segments and stamps are unique.
struct PartOffsets {
  KeyFrameIndex index = 0;    ///< added to the index of each key frame
  std::uint32_t segment = 0;  ///< added to the segment of each key frame and the number of a drive
  Stamp stamp = 0;            ///< added to each stamp, ns
};

/// Offsets of indices and segments of a part that follows these key frames of another one.
PartOffsets offsets_behind(const std::vector<KeyFrame>& key_frames);

/// A loop or a verdict with the indices and stamp that it has in the graph of several sessions.
template <typename LoopOrVerdict>
LoopOrVerdict with_offsets(LoopOrVerdict value, const PartOffsets& offsets) {
  value.from += offsets.index;
  value.to += offsets.index;
  value.stamp += offsets.stamp;
  return value;
}

/// The stamps plus `offset` (ns) of a session's key frames and of its records, which may be at
/// other scans. Throws FileError.
std::set<Stamp> stamps_of(const session::Session& session, Stamp offset = 0);
/// Smallest stamp offset (ns) with which none of the stamps is one of the `known` ones. A session
/// keeps one record at a stamp: with equal ones those of the later part would be left out.
Stamp unique_stamp_offset(const std::set<Stamp>& stamps, const std::set<Stamp>& known);

/// The values by their stamps plus `offset` (ns); of several with the same stamp the first.
template <typename Value>
std::map<Stamp, Value> by_stamp(const std::vector<Value>& values, Stamp offset = 0) {
  std::map<Stamp, Value> result;
  for (Value value : values) {
    value.stamp += offset;
    result.emplace(value.stamp, value);
  }
  return result;
}

/// What the graph needs of one session among several, with its offsets.
struct SessionPart {
  std::vector<KeyFrame> key_frames;          ///< by increasing index, without clouds
  std::map<Stamp, GnssPosition> gnss;        ///< positions by stamp
  std::map<Stamp, ImuSample> imu;            ///< samples by stamp
  std::map<Stamp, Floor> floors;             ///< floors by stamp
  std::multimap<KeyFrameIndex, Loop> loops;  ///< loops within the session, by the newer key frame
};

/// Reads a part. `gnss` are the positions to use, with stamps and frame of the session. Throws
/// FileError.
SessionPart read_part(const session::Session& session, const PartOffsets& offsets,
                      const std::vector<GnssPosition>& gnss);

/// Copies what belongs to a session as a whole: the parameters of its stages, and the position of
/// the LiDAR in base_link. Throws FileError.
void copy_settings(const session::Session& from, session::Session& to);

/// Copies the records that the graph does not need but the report does: states of the scans,
/// odometry at every scan, verdicts on loops. Throws FileError.
void copy_records(const session::Session& from, const PartOffsets& offsets, session::Session& to);
/// The same of those that belong to some of its key frames, which have indices and stamps with the
/// offsets: of the scans from the first to the last one of each segment, and of loops between them.
void copy_records(const session::Session& from, const std::vector<KeyFrame>& key_frames,
                  const PartOffsets& offsets, session::Session& to);

/// Positions of a session in the East-North-Up frame of `datum`; none if that is empty, or if the
/// session does not know the datum of its own ones. Throws FileError.
std::vector<GnssPosition> gnss_in_frame_of(const std::optional<GeodeticDatum>& datum,
                                           const session::Session& session);

/// Adds what a part has measured at this stamp to a BackEnd, RecordedBackEnd or the like.
template <typename BackEnd>
void add_measurements(const SessionPart& part, Stamp stamp, BackEnd& back_end) {
  if (const auto at = part.gnss.find(stamp); at != part.gnss.end()) back_end.add_gnss(at->second);
  if (const auto at = part.imu.find(stamp); at != part.imu.end()) back_end.add_imu(at->second);
  if (const auto at = part.floors.find(stamp); at != part.floors.end()) {
    back_end.add_floor(at->second);
  }
}

/// Adds a key frame of a part to a back end, with what was measured at it, and its position to a
/// LoopCloser, which is given the key frame itself afterwards: by restore() or process().
template <typename BackEnd, typename LoopCloser>
void add_key_frame(const SessionPart& part, const KeyFrame& key_frame, BackEnd& back_end,
                   LoopCloser& closer) {
  back_end.add_key_frame(key_frame);
  add_measurements(part, key_frame.stamp, back_end);
  const auto position = part.gnss.find(key_frame.stamp);
  if (position != part.gnss.end()) closer.add_gnss(position->second);
}

/// Adds the loops of a part whose newer key frame is this one to a back end, and calls `use(loop)`
/// for each that fits its graph.
template <typename BackEnd, typename Use>
void add_loops(const SessionPart& part, KeyFrameIndex newer, BackEnd& back_end, const Use& use) {
  const auto [begin, end] = part.loops.equal_range(newer);
  for (auto loop = begin; loop != end; ++loop) {
    if (back_end.add_loop(loop->second)) use(loop->second);
  }
}

}  // namespace lidar_mapping::pipeline
