// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/scan_map.hpp"

#include <cstdio>

#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/pipeline/scan_clouds.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

#include "drive_input.hpp"
#include "run_record.hpp"

namespace lidar_mapping::tools {

namespace {

using session::Session;

/// Opens the recording with the topics that were mapped, if the session has them.
recordings::DriveSelection selection_of(const Session& session, const ScanMapInput& input) {
  recordings::DriveSelection selection;
  selection.paths = input.recording;
  const auto record = report::read_run_record(session.directory());
  if (!record) return selection;
  const auto topic = [&](const char* sensor) {
    const auto found = record->topics.find(sensor);
    return found == record->topics.end() ? std::string() : found->second;
  };
  selection.topics.points = topic("points");
  selection.topics.imu = topic("imu");
  selection.topics.velocity = topic("velocity");
  selection.topics.gnss = topic("gnss");
  if (record->sensor_height > 0.0) selection.sensor_height = record->sensor_height;
  return selection;
}

}  // namespace

map::Files write_scan_map(const Session& session, const MapOutput& output,
                          const ScanMapInput& input) {
  const auto preprocessing = pipeline::stored_config<preprocessing::PreprocessingConfig>(session);
  const recordings::OpenDrive drive =
      recordings::open_drive(selection_of(session, input), preprocessing);
  const std::vector<pipeline::ScanPose> scans =
      pipeline::scan_poses(session, key_frame_poses(session, output));
  const double as_key_frames =
      pipeline::stored_config<front_end::FrontEndConfig>(session).key_frame_cloud_resolution;
  pipeline::ScanClouds clouds(map_folder(session, output));
  const KeyFramePoses poses = pipeline::add_scans(
      *drive.input, scans, preprocessing,
      {input.every, input.resolution.value_or(as_key_frames), output.threads}, clouds);
  const std::size_t wanted = (scans.size() + static_cast<std::size_t>(input.every) - 1) /
                             static_cast<std::size_t>(input.every);
  if (poses.poses.size() < wanted) {
    std::printf("the recording lacks %zu of %zu scans\n", wanted - poses.poses.size(), wanted);
  }
  return write_map(session, output, poses, clouds, "scans");
}

}  // namespace lidar_mapping::tools
