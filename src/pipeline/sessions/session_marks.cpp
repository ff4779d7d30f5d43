// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_marks.hpp"

#include <map>

#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/session_drives.hpp"

namespace lidar_mapping::pipeline {

namespace {

std::vector<PathPoint> path_of(const session::Session& session, const KeyFramePoses& poses) {
  std::map<KeyFrameIndex, std::uint32_t> segments;
  for (const KeyFrame& key_frame : session.key_frames()) {
    segments[key_frame.index] = key_frame.segment;
  }
  std::vector<PathPoint> path;
  for (const KeyFramePose& pose : poses.poses) {
    const auto segment = segments.find(pose.index);
    if (segment == segments.end()) continue;
    path.push_back({pose.index, segment->second, pose.stamp, pose.T_map_base.translation});
  }
  return path;
}

std::vector<LoopMark> loops_of(const session::Session& session,
                               const std::vector<PathPoint>& path) {
  const auto is_placed = [&](KeyFrameIndex index) { return find_index(path, index) != path.end(); };
  const auto verdicts = newest_verdicts(session.verdicts());
  std::vector<LoopMark> loops;
  for (const Loop& loop : session.loops()) {
    if (!is_placed(loop.from) || !is_placed(loop.to)) continue;
    const auto verdict = verdicts.find({loop.from, loop.to});
    LoopMark mark{loop.from, loop.to, Verdict::kUndecided, "", loop.source};
    if (verdict != verdicts.end()) {
      mark.verdict = verdict->second.verdict;
      mark.reason = verdict->second.reason;
    }
    loops.push_back(mark);
  }
  return loops;
}

/// From where the section begins along the key frames in it to the first one behind it, all of the
/// same drive: another vehicle may have been under way at the same time.
std::vector<Eigen::Vector3d> course_of(const DoubtfulSection& section,
                                       const std::vector<PathPoint>& path) {
  std::vector<Eigen::Vector3d> course = {section.position};
  if (!section.key_frames) return course;
  for (const PathPoint& point : path) {
    if (point.index < section.key_frames->first || point.index > section.key_frames->last) continue;
    if (point.stamp > section.begin) course.push_back(point.p_map);
  }
  return course;
}

/// The same in files of older programs, which do not name the key frames; only a single drive is
/// found by its stamps.
std::vector<Eigen::Vector3d> course_by_stamps(const DoubtfulSection& section,
                                              const std::vector<PathPoint>& path) {
  std::vector<Eigen::Vector3d> course = {section.position};
  for (const PathPoint& point : path) {
    if (point.stamp <= section.begin) continue;
    course.push_back(point.p_map);
    if (point.stamp >= section.end) break;
  }
  return course;
}

std::vector<DoubtMark> doubts_of(const session::Session& session,
                                 const std::vector<PathPoint>& path) {
  const std::filesystem::path file = session.directory() / "doubt.csv";
  if (!std::filesystem::exists(file)) return {};
  const bool is_single = drives_of(session).size() == 1;
  std::vector<DoubtMark> doubts;
  for (const DoubtfulSection& section : read_doubt(file).sections) {
    const auto course = is_single && !section.key_frames ? course_by_stamps(section, path)
                                                         : course_of(section, path);
    doubts.push_back({to_string(section.doubt), section.begin, section.end, section.path_length,
                      section.expected_error, section.is_trusted, course});
  }
  return doubts;
}

}  // namespace

DriveMarks session_marks(const session::Session& session, const KeyFramePoses& poses) {
  DriveMarks marks;
  marks.path = path_of(session, poses);
  marks.loops = loops_of(session, marks.path);
  marks.doubts = doubts_of(session, marks.path);
  return marks;
}

}  // namespace lidar_mapping::pipeline
