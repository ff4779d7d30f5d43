// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/session_map.hpp"

#include <Eigen/Geometry>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"
#include "lidar_mapping/session/map_datum.hpp"

namespace lidar_mapping::pipeline {

namespace {

using session::Session;

/// A session of an older version may not know where its LiDAR was. The viewpoint only tells the
/// sides of thin plates apart, so base_link, which is some metres from it, stands for it.
localization::MapSource source_of(const Session& session) {
  localization::MapSource source;
  source.key_frames = session.key_frames();
  source.poses = session.poses();
  source.p_base_lidar = session.sensor_origin().value_or(Eigen::Vector3d::Zero());
  if (!source.poses.poses.empty()) return source;
  throw InputError("the session in " + session.directory().string() +
                   " has no optimised poses, so it is no map yet; optimize_session makes them");
}

Session opened(const std::filesystem::path& folder) {
  // Chosen: the key frames around a candidate of 64 beams; who follows reads none.
  constexpr std::size_t kCacheBytes = std::size_t{16} << 20U;
  Session session = Session::open(folder, Session::Access::kRead);
  session.clouds().set_cache_bytes(kCacheBytes);
  return session;
}

/// The middle of the key frames, at a corner of voxels with this edge (m). Points are thinned from
/// there, because a filter in single precision knows none that are too far from its origin.
Eigen::Vector3d middle_of(const KeyFramePoses& poses, double resolution) {
  Eigen::AlignedBox3d box;
  for (const KeyFramePose& pose : poses.poses) box.extend(pose.T_map_base.translation);
  return resolution * (box.center() / resolution).array().round().matrix();
}

}  // namespace

SessionMap::SessionMap(const std::filesystem::path& folder,
                       const loop_closing::LoopClosingConfig& verification, int threads)
    : session_(opened(folder)),
      index_(source_of(session_), session_.clouds(), verification,
             std::filesystem::temp_directory_path(), threads) {}

PointCloud SessionMap::cloud(double resolution) const {
  const KeyFramePoses poses = session_.poses();
  const Eigen::Vector3d p_map_middle = middle_of(poses, resolution);
  loop_closing::VoxelMeans voxels;
  voxels.reset(resolution);
  for (const KeyFramePose& pose : poses.poses) {
    const PointCloudPtr cloud = session_.clouds().cloud(pose.index);
    if (!cloud) continue;
    const Pose T_middle_base{pose.T_map_base.rotation, pose.T_map_base.translation - p_map_middle};
    for (const Point& p : transformed(*cloud, T_middle_base).points) voxels.add(p.position());
  }
  PointCloud result;
  for (const Eigen::Vector3f& p : voxels.points()) {
    const Eigen::Vector3f p_map = (p.cast<double>() + p_map_middle).cast<float>();
    result.points.push_back({p_map.x(), p_map.y(), p_map.z()});
  }
  return result;
}

std::string SessionMap::size_text() const {
  constexpr double kMegabyte = 1e6;  // bytes, by SI
  std::string text = formatted("%zu places, ", index_.places().size());
  if (index_.places_without_cloud() > 0) {
    text += formatted("%zu of them without cloud, ", index_.places_without_cloud());
  }
  return text + formatted("%zu Gaussians, tables of %.0f MB", index_.gaussians(),
                          static_cast<double>(index_.bytes()) / kMegabyte);
}

std::optional<GeodeticDatum> SessionMap::datum() const {
  // Of an older session, which does not know it, positions are a sign.
  const bool is_in_enu = session::is_imported_map(session_) || !session_.gnss().empty();
  return is_in_enu ? session::map_datum(session_) : std::nullopt;
}

}  // namespace lidar_mapping::pipeline
