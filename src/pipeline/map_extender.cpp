// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/map_extender.hpp"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "lidar_mapping/back_end/pose_change.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/session_merger.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "scan_odometry.hpp"

namespace lidar_mapping::pipeline {

namespace {

namespace fs = std::filesystem;
using back_end::BackEndConfig;
using session::Session;

/// What the new session keeps of a scan.
struct ScanOfDrive {
  session::ScanRecord record;
  Pose T_odom_base;
};

/// Hidden, beside the session, so that clouds can be linked.
fs::path folder_beside(const fs::path& session) {
  const fs::path whole = (fs::absolute(session) / "").lexically_normal().parent_path();
  return whole.parent_path() / ("." + whole.filename().string() + ".drive.part");
}

/// The key frames of each stretch; a stretch is a segment of its own, because no odometry leads to
/// it from the one before.
std::vector<KeyFrame> key_frames_of(const MapExtension& extension,
                                    const std::vector<LocalizedKeyFrame>& drive) {
  std::vector<KeyFrame> key_frames;
  std::uint32_t segment = 0;
  for (const NewStretch& stretch : extension.stretches) {
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      key_frames.push_back(drive[i].key_frame);
      key_frames.back().segment = segment;
    }
    ++segment;
  }
  return key_frames;
}

std::vector<Loop> ties_of(const MapExtension& extension) {
  std::vector<Loop> ties;
  for (const NewStretch& stretch : extension.stretches) {
    ties.insert(ties.end(), stretch.ties.begin(), stretch.ties.end());
  }
  return ties;
}

/// Offsets of a drive behind all of a session.
PartOffsets offsets_behind(const Session& session) {
  PartOffsets offsets;
  for (const KeyFrame& key_frame : session.key_frames()) {
    offsets.index = key_frame.index + 1;
    offsets.segment = key_frame.segment + 1;
  }
  return offsets;
}

/// The key frames of the drive with a tie that the graph of map and drive uses.
std::set<KeyFrameIndex> held_key_frames(const Session& map, const BackEndConfig& config,
                                        const MapExtension& extension,
                                        const std::vector<LocalizedKeyFrame>& drive) {
  back_end::BackEnd graph(config);
  replay(map, graph);
  const PartOffsets offsets = offsets_behind(map);
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

/// Leaves out the stretches of which the graph refuses most ties.
void leave_out_contradicted(const std::set<KeyFrameIndex>& held, MapExtension& extension) {
  std::vector<NewStretch> kept;
  for (NewStretch& stretch : extension.stretches) {
    const auto used = static_cast<std::size_t>(
        std::count_if(stretch.ties.begin(), stretch.ties.end(),
                      [&](const Loop& tie) { return held.count(tie.to) > 0; }));
    if (used >= kLeastTies && 2 * used >= stretch.ties.size()) {
      kept.push_back(std::move(stretch));
    } else {
      extension.left_out.not_tied += stretch.new_way;
    }
  }
  extension.stretches = std::move(kept);
}

void merge(const Session& map, const Session& drive, const std::vector<Loop>& ties,
           const BackEndConfig& config, Session&& out) {
  SessionMerger merger(std::move(out), config, stored_config<loop_closing::LoopClosingConfig>(map));
  merger.add(map);
  merger.add(drive, ties);
  merger.finish();
  if (merger.parts().back().is_connected) return;
  throw InputError("the loops between the map " + map.directory().string() +
                   " and what the drive adds contradict its places in the map, so no session is "
                   "written; map the drive with map_bag and join the two with merge_sessions");
}

}  // namespace

class MapExtender::Impl {
 public:
  Impl(const fs::path& map, const fs::path& session)
      : map_(Session::open(map, Session::Access::kRead)),
        config_(stored_config<BackEndConfig>(map_)),
        session_(session),
        folder_(folder_beside(session)) {
    check_config();
    fs::remove_all(folder_);
    recorded_ = std::make_unique<Session>(Session::create_in(folder_));
    recorded_->clouds().set_cache_bytes(0);  // nobody asks for them before the end
  }
  ~Impl() {
    recorded_.reset();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add(const front_end::FrontEndResult& odometry,
           const localization::LocalizationResult& place) {
    scans_.push_back({record_of(odometry), odometry.T_odom_base});
    if (!odometry.key_frame) return;
    LocalizedKeyFrame localized{*odometry.key_frame, place};
    KeyFrame& key_frame = localized.key_frame;
    if (key_frame.cloud) recorded_->clouds().put(key_frame.index, key_frame.cloud);
    key_frame.cloud = nullptr;
    drive_.push_back(std::move(localized));
  }

  ExtensionReport write() {
    const KeyFramePoses before = map_.poses();
    ExtensionReport report;
    report.extension = plan_extension(drive_, before);
    if (report.is_written()) {
      leave_out_contradicted(held_key_frames(map_, config_, report.extension, drive_),
                             report.extension);
    }
    if (!report.is_written()) return report;
    record(report.extension);
    report.key_frames = recorded_->key_frame_count();
    const Session extended = session::create_filled(session_, [&](Session& out) {
      merge(map_, *recorded_, ties_of(report.extension), config_, std::move(out));
    });
    report.largest_move = back_end::change_between(before, extended.poses()).largest;
    return report;
  }

 private:
  void check_config() const {
    if (config_.use_loop_close) return;
    throw InputError("the map " + map_.directory().string() +
                     " was made with use_loop_close: false, and loops would hold what is added to "
                     "it; make the map with use_loop_close: true");
  }

  /// Stores the stretches as a drive of their own; their clouds are there already.
  void record(const MapExtension& extension) {
    Session::Batch batch(*recorded_);
    for (const KeyFrame& key_frame : key_frames_of(extension, drive_)) {
      recorded_->add_key_frame(key_frame);
    }
    for (const NewStretch& stretch : extension.stretches) {
      record_scans(drive_[stretch.begin].key_frame.stamp, drive_[stretch.end - 1].key_frame.stamp);
    }
    batch.commit();
  }

  void record_scans(Stamp first, Stamp last) {
    for (const ScanOfDrive& scan : scans_) {
      if (scan.record.stamp < first || scan.record.stamp > last) continue;
      recorded_->add_scan(scan.record);
      recorded_->add_odometry(scan.record.stamp, scan.T_odom_base);
    }
  }

  const Session map_;
  const BackEndConfig config_;
  const fs::path session_;
  const fs::path folder_;
  std::unique_ptr<Session> recorded_;
  std::vector<ScanOfDrive> scans_;
  std::vector<LocalizedKeyFrame> drive_;
};

MapExtender::MapExtender(const fs::path& map, const fs::path& session)
    : impl_(std::make_unique<Impl>(map, session)) {}
MapExtender::~MapExtender() = default;

void MapExtender::add(const front_end::FrontEndResult& odometry,
                      const localization::LocalizationResult& place) {
  impl_->add(odometry, place);
}
ExtensionReport MapExtender::write() { return impl_->write(); }

}  // namespace lidar_mapping::pipeline
