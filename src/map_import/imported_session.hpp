// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/session.hpp"

#include "map_import.hpp"
#include "places.hpp"

namespace lidar_mapping::map_import {

/// Writes the key frames of an imported map as those of one segment, with the poses of the map as
/// odometry and as optimised poses.
class SessionWriter {
 public:
  /// The session must outlive this object.
  explicit SessionWriter(session::Session& session) : session_(session) {}

  /// Writes datum, LiDAR (in base_link, m) and parameters; before the first key frame. `origin` is
  /// that of the session's frame in that of the map, m.
  void describe(const ImportOptions& options, const Eigen::Vector3d& origin,
                const Eigen::Vector3d& p_base_lidar, const std::optional<GeodeticDatum>& datum);
  /// Writes a key frame with its cloud in base_link.
  void add(const Place& place, PointCloud&& cloud);
  /// Writes the poses of all key frames and the trajectory files.
  void finish();

  std::size_t key_frames() const { return poses_.poses.size(); }
  std::uint64_t points() const { return points_; }  ///< of all key frames

 private:
  session::Session& session_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  KeyFramePoses poses_;
  std::uint64_t points_ = 0;
};

}  // namespace lidar_mapping::map_import
