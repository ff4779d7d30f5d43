// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/map_extender.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include "lidar_mapping/back_end/pose_change.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/pipeline/session_merger.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;
using back_end::BackEndConfig;
using session::Session;

/// The key frames of each section; a section is a segment of its own, because no odometry leads to
/// it from the one before.
std::vector<KeyFrame> key_frames_of(const MapExtension& extension,
                                    const std::vector<LocalizedKeyFrame>& drive) {
  std::vector<KeyFrame> key_frames;
  std::uint32_t segment = 0;
  for (const NewSection& section : extension.sections) {
    for (std::size_t i = section.begin; i < section.end; ++i) {
      key_frames.push_back(drive[i].key_frame);
      key_frames.back().segment = segment;
    }
    ++segment;
  }
  return key_frames;
}

std::vector<Loop> ties_of(const MapExtension& extension) {
  std::vector<Loop> ties;
  for (const NewSection& section : extension.sections) {
    ties.insert(ties.end(), section.ties.begin(), section.ties.end());
  }
  return ties;
}

/// The key frames of the drive with a tie that the graph of map and drive uses.
std::set<KeyFrameIndex> held_key_frames(const Session& map, const BackEndConfig& config,
                                        const MapExtension& extension,
                                        const std::vector<LocalizedKeyFrame>& drive) {
  back_end::BackEnd graph(config);
  replay(map, graph);
  const PartOffsets offsets = offsets_behind(map.key_frames());
  for (KeyFrame key_frame : key_frames_of(extension, drive)) {
    key_frame.index += offsets.index;
    key_frame.segment += offsets.segment;
    graph.add_key_frame(key_frame);
  }
  for (Loop tie : ties_of(extension)) {
    tie.to += offsets.index;
    graph.add_loop(tie);
  }
  graph.apply(*back_end::solve(*graph.problem(true)));
  std::set<KeyFrameIndex> held;
  for (const auto& [loop, is_used] : graph.loops()) {
    if (is_used && loop.to >= offsets.index) held.insert(loop.to - offsets.index);
  }
  return held;
}

/// Leaves out the sections of which the graph refuses most ties.
void leave_out_contradicted(const std::set<KeyFrameIndex>& held, MapExtension& extension) {
  std::vector<NewSection> kept;
  for (NewSection& section : extension.sections) {
    const auto used = static_cast<std::size_t>(
        std::count_if(section.ties.begin(), section.ties.end(),
                      [&](const Loop& tie) { return held.count(tie.to) > 0; }));
    if (used >= kLeastTies && 2 * used >= section.ties.size()) {
      kept.push_back(std::move(section));
    } else {
      extension.omitted.not_tied += section.new_path_length;
    }
  }
  extension.sections = std::move(kept);
}

void merge(const Session& map, const Session& drive, const std::vector<Loop>& ties,
           const BackEndConfig& config, Session&& out) {
  SessionMerger merger(std::move(out), config, stored_config<loop_closing::LoopClosingConfig>(map));
  merger.add(map);
  merger.add(drive, ties);
  merger.finish();
  if (merger.parts().back().is_connected) return;
  throw InputError(
      "the loops between the map " + map.directory().string() +
      " and the new parts of the drive contradict the places at which the drive was localised, so "
      "no session is written; map the drive with map_bag and merge both with merge_sessions");
}

/// The sections of a drive as a session, which goes with this object.
class SectionSession {
 public:
  /// The clouds are links to those in `clouds`.
  SectionSession(const fs::path& folder, const MapExtension& extension, const LocalizedDrive& drive,
                 const session::CloudStore& clouds)
      : folder_(folder) {
    fs::remove_all(folder_);
    session_ = std::make_unique<Session>(Session::create_in(folder_));
    Session::Batch batch(*session_);
    for (const KeyFrame& key_frame : key_frames_of(extension, drive.key_frames)) {
      session_->add_key_frame(key_frame);
      if (!clouds.contains(key_frame.index)) continue;
      session_->clouds().link(key_frame.index, clouds.file(key_frame.index));
    }
    for (const NewSection& section : extension.sections) {
      add_scans(drive, drive.key_frames[section.begin].key_frame.stamp,
                drive.key_frames[section.end - 1].key_frame.stamp);
    }
    batch.commit();
  }
  ~SectionSession() {
    session_.reset();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  SectionSession(const SectionSession&) = delete;
  SectionSession& operator=(const SectionSession&) = delete;

  const Session& session() const { return *session_; }

 private:
  void add_scans(const LocalizedDrive& drive, Stamp first, Stamp last) {
    for (const session::ScanRecord& scan : drive.scans) {
      if (scan.stamp >= first && scan.stamp <= last) session_->add_scan(scan);
    }
    for (const auto& [stamp, T_odom_base] : drive.odometry) {
      if (stamp >= first && stamp <= last) session_->add_odometry(stamp, T_odom_base);
    }
  }

  const fs::path folder_;
  std::unique_ptr<Session> session_;
};

BackEndConfig checked_config(const fs::path& map) {
  const Session session = Session::open(map, Session::Access::kRead);
  const BackEndConfig config = stored_config<BackEndConfig>(session);
  if (config.use_loop_close) return config;
  throw InputError("the map " + session.directory().string() +
                   " was made with use_loop_close: false, but new parts are connected to it by "
                   "loops; make the map with use_loop_close: true");
}

}  // namespace

fs::path folder_beside(const fs::path& session) { return hidden_beside(session, ".drive.part"); }

MapExtender::MapExtender(const fs::path& map, const fs::path& folder)
    : map_(fs::canonical(session::find_session(map))),
      config_(checked_config(map)),
      folder_(folder),
      clouds_(folder / "clouds", 0) {  // nobody asks for them before the end
  std::error_code error;
  fs::remove_all(folder_, error);
  if (!error) fs::create_directories(folder_, error);
  if (!error) return;
  throw FileError("cannot make the folder " + folder_.string() + ": " + error.message() +
                  "; check the path and the free space");
}

MapExtender::~MapExtender() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void MapExtender::add_key_frame(const KeyFrame& key_frame,
                                const localization::LocalizationResult& place) {
  if (key_frame.cloud) clouds_.put(key_frame.index, key_frame.cloud);
  drive_.key_frames.push_back({key_frame, place});
  drive_.key_frames.back().key_frame.cloud = nullptr;
}

void MapExtender::withdraw_places(Stamp since) {
  for (LocalizedKeyFrame& localized : drive_.key_frames) {
    if (localized.key_frame.stamp < since) continue;
    localized.place.state = localization::LocalizationState::kSearching;
  }
}

ExtensionReport MapExtender::write(const LocalizedDrive& drive, const fs::path& session) const {
  const Session map = Session::open(map_, Session::Access::kRead);
  const KeyFramePoses before = map.poses();
  ExtensionReport report;
  report.extension = plan_extension(drive.key_frames, before);
  if (report.is_written()) {
    leave_out_contradicted(held_key_frames(map, config_, report.extension, drive.key_frames),
                           report.extension);
  }
  if (!report.is_written()) return report;
  const SectionSession sections(folder_ / "sections", report.extension, drive, clouds_);
  report.key_frames = sections.session().key_frame_count();
  const Session extended = session::create_filled(session, [&](Session& out) {
    merge(map, sections.session(), ties_of(report.extension), config_, std::move(out));
  });
  report.largest_move = back_end::change_between(before, extended.poses()).largest;
  return report;
}

}  // namespace lidar_mapping::pipeline
