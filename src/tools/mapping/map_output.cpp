// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_output.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/evaluation/association.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"
#include "lidar_mapping/pipeline/session_marks.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"
#include "lidar_mapping/session/map_datum.hpp"

namespace lidar_mapping::tools {

namespace {

using map::MapConfig;
using session::Session;

/// Bytes. Clouds are read in the order of the drive, first as observers and thirty key frames later
/// to be judged and put into the map. Chosen: so much is between the two with 50,000 points each.
constexpr std::size_t kCacheBytes = session::CloudStore::kDefaultCacheBytes / 2;

/// The clouds of key frames; counts those that are missing or damaged.
class CountedClouds : public CloudSource {
 public:
  explicit CountedClouds(CloudSource& clouds) : clouds_(clouds) {}

  PointCloudPtr cloud(KeyFrameIndex index) override { return clouds({index}, 1).front(); }
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override {
    std::vector<PointCloudPtr> found = clouds_.clouds(indices, threads);
    const std::lock_guard<std::mutex> lock(mutex_);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (!found[i]) missing_.insert(indices[i]);
    }
    return found;
  }
  std::size_t missing() const { return missing_.size(); }

 private:
  CloudSource& clouds_;
  std::mutex mutex_;  ///< guards missing_
  std::set<KeyFrameIndex> missing_;
};

/// `stored`, and over it the command line.
MapConfig make_config(const MapOutput& output, const config::Source& stored) {
  std::vector<config::Source> sources = {stored};
  const auto add = [&](const char* option, const char* name, const std::optional<double>& value) {
    if (value) sources.push_back({option, {config::Value::Map{{name, {*value}}}}});
  };
  add("--resolution", "resolution", output.resolution);
  add("--tile-size", "tile_size", output.tile_size);
  add("--cell", "grid_cell", output.grid_cell);
  MapConfig config = config::load<MapConfig>(sources);
  config.threads = output.threads;
  return config;
}

/// From the command line, or else from the session.
std::optional<Eigen::Vector3d> sensor_origin_of(const MapOutput& output, const Session& session) {
  if (output.sensor_origin.size() == 3) return Eigen::Vector3d(output.sensor_origin.data());
  const auto origin = session.sensor_origin();
  if (!origin) {
    std::cerr << "the session does not know where the LiDAR is in base_link, so points of moving "
                 "objects stay and the grid is unknown where no point lies; give --sensor-origin "
                 "x y z\n";
  }
  return origin;
}

/// The poses that the trajectory of the command line has of the key frames.
KeyFramePoses given_poses(const Session& session, const MapOutput& output) {
  const Trajectory trajectory = read_trajectory(output.poses);
  if (!trajectory.has_stamps) {
    throw InputError(output.poses + " has no stamps; give a TUM file");
  }
  KeyFramePoses placed;
  Trajectory wanted;
  for (const KeyFrame& key_frame : session.key_frames()) {
    wanted.poses.push_back({key_frame.stamp, {}});
    const auto pose = pose_at(key_frame.stamp, trajectory, evaluation::kLargestGap);
    if (pose) placed.poses.push_back({key_frame.index, key_frame.stamp, *pose});
  }
  const evaluation::LeftOut left_out = evaluation::left_out(trajectory, wanted);
  const std::string reason = evaluation::reason_of(left_out, output.poses);
  if (placed.poses.empty()) {
    throw InputError("no key frame has a pose: " + reason + "; " +
                     (left_out.in_gaps > 0 ? evaluation::remedy_for(left_out)
                                           : std::string("is it of this drive?")));
  }
  if (!reason.empty()) {
    std::cerr << "only " << placed.poses.size() << " of " << wanted.poses.size()
              << " key frames have a pose: " << reason << '\n';
  }
  return placed;
}

/// The poses up to an instant.
KeyFramePoses until(Stamp last, KeyFramePoses poses) {
  auto& list = poses.poses;
  if (list.empty()) return poses;
  const auto by_stamp = [](const KeyFramePose& a, const KeyFramePose& b) {
    return a.stamp < b.stamp;
  };
  const Stamp first = std::min_element(list.begin(), list.end(), by_stamp)->stamp;
  if (first > last) {
    throw InputError("no key frame is as old as the date of --as-of; the first one is of " +
                     iso_date(first));
  }
  list.erase(std::remove_if(list.begin(), list.end(),
                            [&](const KeyFramePose& pose) { return pose.stamp > last; }),
             list.end());
  return poses;
}

}  // namespace

void check_numbers(const MapOutput& output) {
  map::check_formats(output.products.formats, make_config(output, {}));
}

KeyFramePoses key_frame_poses(const Session& session) {
  map::KeyFrameTrack track;
  for (const KeyFrame& key_frame : session.key_frames()) track.add(key_frame);
  track.update(session.poses());
  return track.poses();
}

KeyFramePoses key_frame_poses(const Session& session, const MapOutput& output) {
  KeyFramePoses poses =
      output.poses.empty() ? key_frame_poses(session) : given_poses(session, output);
  return output.as_of.empty() ? poses : until(end_of_date(output.as_of), std::move(poses));
}

std::filesystem::path map_folder(const Session& session, const MapOutput& output) {
  return output.folder.empty() ? session.directory() / "map" : std::filesystem::path(output.folder);
}

map::Files write_map(const Session& session, const MapOutput& output) {
  session.clouds().set_cache_bytes(kCacheBytes);
  CountedClouds clouds(session.clouds());
  map::Files files =
      write_map(session, output, key_frame_poses(session, output), clouds, "key frames");
  if (clouds.missing() > 0) {
    std::printf("%zu of them without cloud, which is missing or damaged: the map lacks them\n",
                clouds.missing());
  }
  return files;
}

map::Files write_map(const Session& session, const MapOutput& output, const KeyFramePoses& poses,
                     CloudSource& clouds, const std::string& name) {
  const MapConfig config = make_config(output, pipeline::stored_configuration<MapConfig>(session));
  map::ProductOptions options = output.products;
  // A trajectory that a person gives lies where the positions do, as ground_truth.tum.
  options.datum = output.poses.empty() ? session::map_datum(session) : session.datum();
  options.p_base_sensor = sensor_origin_of(output, session);
  options.marks = [&] {
    return pipeline::session_marks(session, key_frame_poses(session, output));
  };
  const map::Products products =
      map::write_products(poses, clouds, config, options, map_folder(session, output));
  // Some products, such as GeoJSON, need no points.
  if (products.points > 0) std::printf("%zu points of ", products.points);
  std::printf("%zu %s\n", poses.poses.size(), name.c_str());
  if (products.visits > 1) {
    std::printf("%zu visits; ", products.visits);
    options.keep_outdated ? std::printf("what was not there any more is kept\n")
                          : std::printf("%zu points of what was not there any more are left out\n",
                                        products.outdated);
  }
  if (options.save_removed) std::printf("%zu points of moving objects\n", products.removed);
  return products.files;
}

}  // namespace lidar_mapping::tools
