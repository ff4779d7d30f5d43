// SPDX-License-Identifier: BSD-3-Clause
#include "imported_session.hpp"

#include <memory>
#include <utility>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/session/imported_map.hpp"
#include "lidar_mapping/session/trajectory_files.hpp"

namespace lidar_mapping::map_import {

namespace {

// Standard deviations of a pose relative to the one before, at first and for each metre between
// them. Chosen: nothing is known of the map's errors, so the first two are those of a loop
// (min_stddev_x and min_stddev_q of loop closing), and the others are those of a map that is off by
// 0.5 m and half a degree after 100 m.
constexpr double kStddev_m = 0.05;
constexpr double kStddev_rad = 0.002;
constexpr double kStddevPerMetre_m = 0.005;
constexpr double kStddevPerMetre_rad = 1e-4;

Covariance6 covariance_over(double distance) {
  return diagonal_covariance(kStddev_m + kStddevPerMetre_m * distance,
                             kStddev_rad + kStddevPerMetre_rad * distance);
}

std::string to_yaml(const ImportOptions& options, const Eigen::Vector3d& origin) {
  std::string text = "map: " + quoted(options.map.string(), '\'') + "\n";
  text += "trajectory: " + quoted(options.trajectory, '\'') + "\n";
  text += formatted("origin: [%.0f, %.0f, %.0f]\n", origin.x(), origin.y(), origin.z());
  text += formatted("spacing: %g\n", options.spacing);
  text += formatted("sensor_height: %g\n", options.sensor_height);
  text += formatted("base_height: %g\n", options.base_height);
  return text + formatted("resolution: %g\n", options.resolution);
}

}  // namespace

void SessionWriter::describe(const ImportOptions& options, const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& p_base_lidar,
                             const std::optional<GeodeticDatum>& datum) {
  origin_ = origin;
  session_.set_configuration(session::kImportedMap, to_yaml(options, origin));
  session_.set_sensor_origin(p_base_lidar);
  if (datum) session_.set_datum(*datum);
}

void SessionWriter::add(const Place& place, PointCloud&& cloud) {
  KeyFrame key_frame;
  key_frame.index = static_cast<KeyFrameIndex>(poses_.poses.size());
  key_frame.stamp = place.stamp;
  key_frame.T_odom_base = place.T_map_base;
  key_frame.T_odom_base.translation -= origin_;
  if (!poses_.poses.empty()) {
    const Pose& before = poses_.poses.back().T_map_base;
    key_frame.motion_covariance =
        covariance_over((key_frame.T_odom_base.translation - before.translation).norm());
  }
  points_ += cloud.size();
  key_frame.cloud = std::make_shared<const PointCloud>(std::move(cloud));
  session_.add_key_frame(key_frame);
  poses_.poses.push_back({key_frame.index, key_frame.stamp, key_frame.T_odom_base});
}

void SessionWriter::finish() {
  poses_.revision = 1;
  session::RevisionRecord record;
  record.revision = poses_.revision;
  record.key_frames = poses_.poses.size();
  session_.set_poses(poses_, record);
  session::write_trajectories(session_, poses_, {}, session_.directory() / "trajectory");
}

}  // namespace lidar_mapping::map_import
