// SPDX-License-Identifier: BSD-3-Clause
#include "city_session.hpp"

#include <algorithm>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

namespace lidar_mapping::city {

namespace {

namespace fs = std::filesystem;
using pipeline::RecordedBackEnd;
using session::Session;

void add_drive(const JoinedDrive& drive, const std::optional<GeodeticDatum>& datum,
               RecordedBackEnd& back_end) {
  const Session session = Session::open(drive.session, Session::Access::kRead);
  const auto part = pipeline::read_part(
      session, drive.offsets,
      pipeline::gnss_in_frame_of(drive.uses_gnss ? datum : std::nullopt, session));
  session::CloudStore& clouds = back_end.session().clouds();
  Session::Batch batch(back_end.session());
  for (const KeyFrame& key_frame : drive.key_frames) {
    const KeyFrameIndex own_index = key_frame.index - drive.offsets.index;
    if (session.clouds().contains(own_index)) {
      clouds.link(key_frame.index, session.clouds().file(own_index));
    }
    back_end.add_key_frame(key_frame);
    add_measurements(part, key_frame.stamp, back_end);
  }
  for (const auto& [newer, loop] : part.loops) {
    if (!back_end.add_loop(loop) || loop.decision == LoopDecision::kAuto) continue;
    back_end.session().set_loop_decision(loop.from, loop.to, loop.decision);
  }
  batch.commit();
}

/// The records of a drive, or of the part of it that is in the city.
void add_records(const JoinedDrive& drive, Session& city) {
  const Session session = Session::open(drive.session, Session::Access::kRead);
  if (drive.left_out == 0) return copy_records(session, drive.offsets, city);
  copy_records(session, drive.key_frames, drive.offsets, city);
}

/// The poses of a drive with its own stamps.
void write_trajectory(const JoinedDrive& drive, const KeyFramePoses& poses,
                      const fs::path& folder) {
  Trajectory trajectory;
  auto pose = poses.poses.begin();
  for (const KeyFrame& key_frame : drive.key_frames) {
    while (pose->index < key_frame.index) ++pose;
    trajectory.poses.push_back({pose->stamp - drive.offsets.stamp, pose->T_map_base});
  }
  write_text_atomically(folder / "drives" / (drive.name + ".tum"), to_tum(trajectory));
}

void fill(const JoinedCity& city, const back_end::BackEndConfig& config, const JoinedDrive& first,
          Session& session) {
  pipeline::copy_settings(Session::open(first.session, Session::Access::kRead), session);
  if (city.datum) session.set_datum(*city.datum);
  RecordedBackEnd back_end(std::move(session), config);
  for (const JoinedDrive& drive : city.drives) {
    if (drive.key_frames.empty()) continue;
    add_records(drive, back_end.session());
    add_drive(drive, city.datum, back_end);
  }
  for (const Loop& loop : city.loops) back_end.add_loop(loop);
  // The time is not kept: the same drives give the same bytes.
  const KeyFramePoses poses = back_end.apply(*back_end::solve(*back_end.problem(true)), 0.0).poses;
  back_end.write_files();
  for (const JoinedDrive& drive : city.drives) {
    if (!drive.key_frames.empty()) write_trajectory(drive, poses, back_end.session().directory());
  }
}

}  // namespace

void write_city(const JoinedCity& city, const back_end::BackEndConfig& config,
                const fs::path& folder) {
  const auto first =
      std::find_if(city.drives.begin(), city.drives.end(),
                   [](const JoinedDrive& drive) { return !drive.key_frames.empty(); });
  if (first == city.drives.end()) {
    throw InputError(
        "no drive has a key frame, so there is no city; the reports of the drives may show the "
        "cause");
  }
  session::create_filled(folder, [&](Session& session) { fill(city, config, *first, session); });
}

}  // namespace lidar_mapping::city
