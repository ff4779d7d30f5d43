// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/pipeline/extension_lines.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"

#include "localization_node.hpp"
#include "scan_record.hpp"
#include "worker_tasks.hpp"

// The drive that is recorded, and the service save_session.
namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;

/// Throws InputError or FileError if no session can be written there.
fs::path new_session_folder(const std::string& path) {
  if (path.empty()) throw InputError("path is empty; name the folder of the new session");
  fs::path folder = expanded_path(path);
  check_new_folder(folder);
  return folder;
}

bool is_found(const pipeline::LocalizedDrive& drive) {
  return std::any_of(drive.key_frames.begin(), drive.key_frames.end(), [](const auto& localized) {
    return localized.place.state == localization::LocalizationState::kFollowing;
  });
}

}  // namespace

/// Of the front end, beside what localisation itself needs. Without a recording their clouds would
/// only burden the network.
void LocalizationNode::subscribe_drive() {
  const int capacity = config_.node.queue_size;
  subscribers_.push_back(subscribe_numbered<KeyFrameMessage>(
      context_, "key_frame", capacity, [this](const auto& m) { key_frames_.push(received(*m)); }));
  subscribers_.push_back(subscribe_numbered<FrontEndStatusMessage>(
      context_, "front_end_status", capacity, [this](const auto& m) {
        if (pipeline::DriveRecorder* const recorder = present_recorder())
          recorder->add_scan(to_record(*m));
      }));
}

/// Each map has a recording of its own. A map that cannot be extended is good for localisation all
/// the same.
void LocalizationNode::begin_recording(ActiveMap& active_map) {
  if (!scratch_) {
    active_map.why_not_recorded =
        "nothing is recorded; start localization_node with record_session: true";
    return;
  }
  try {
    active_map.recorder.emplace(std::make_shared<pipeline::MapExtender>(
        active_map.map.directory(), scratch_->path() / std::to_string(++recordings_)));
  } catch (const Error& error) {
    active_map.why_not_recorded = std::string("nothing is recorded: ") + error.what();
    ROS_WARN_STREAM(active_map.why_not_recorded);
  }
}

pipeline::DriveRecorder* LocalizationNode::present_recorder() {
  return active_map_ && active_map_->recorder ? &*active_map_->recorder : nullptr;
}

void LocalizationNode::record(const RunKeyFrame& received) {
  pipeline::DriveRecorder* const recorder = present_recorder();
  if (recorder == nullptr) return;
  recorder->add_key_frame(received);
  context_.diagnostics.set("key frames given up", key_frames_.missing());
}

void LocalizationNode::record(const localization::LocalizationResult& place) {
  pipeline::DriveRecorder* const recorder = present_recorder();
  if (recorder == nullptr) return;
  recorder->add_place(place);
  context_.diagnostics.set("key frames recorded", recorder->drive().key_frames.size());
}

void LocalizationNode::withdraw_place() {
  if (pipeline::DriveRecorder* const recorder = present_recorder()) recorder->withdraw_place();
}

/// Writing takes longer than scans can wait, so the worker gives a copy of the drive to the loader.
bool LocalizationNode::save_session(SaveSession::Request& request,
                                    SaveSession::Response& response) {
  return answered(response, [&] {
    const fs::path folder = new_session_folder(request.path);
    const DriveSoFar drive =
        result_in(context_.worker, requests_, [this] { return drive_so_far(); });
    return result_in(loader_, loads_, [&] { return saved(drive, folder); });
  });
}

LocalizationNode::DriveSoFar LocalizationNode::drive_so_far() {
  if (!active_map_) throw InputError(loading_);
  key_frames_.flush();
  const pipeline::DriveRecorder* const recorder = present_recorder();
  if (recorder == nullptr) throw InputError(active_map_->why_not_recorded);
  if (!is_found(recorder->drive())) {
    throw InputError("the place was not found in the map " + active_map_->map.directory().string() +
                     " since the recording began, so nothing can be added to it; drive until "
                     "localization_status says following");
  }
  return {recorder->extender(), recorder->drive()};
}

SaveSession::Response LocalizationNode::saved(const DriveSoFar& recorded, const fs::path& folder) {
  const pipeline::ExtensionReport report = recorded.extender->write(recorded.drive, folder);
  SaveSession::Response response;
  response.success = report.is_written();
  response.message = joined(pipeline::extension_lines(report), "; ");
  response.key_frames = static_cast<std::uint32_t>(report.key_frames);
  if (response.success) ROS_INFO_STREAM("session " << folder.string() << ": " << response.message);
  return response;
}

}  // namespace lidar_mapping::ros_border
