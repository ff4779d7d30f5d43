// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/datum.hpp"

#include <vector>

#include <GeographicLib/LocalCartesian.hpp>

#include "lidar_mapping/common/unknown_height.hpp"

namespace lidar_mapping::pipeline {

Pose enu_between(const GeodeticDatum& to, const GeodeticDatum& from) {
  if (to == from) return Pose::Identity();
  const GeographicLib::LocalCartesian local(to.latitude_deg, to.longitude_deg, to.altitude_m);
  Pose pose;
  std::vector<double> rotation(9);
  local.Forward(from.latitude_deg, from.longitude_deg, from.altitude_m, pose.translation.x(),
                pose.translation.y(), pose.translation.z(), rotation);
  pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  return pose;
}

GnssPosition transformed_position(GnssPosition position, const Pose& T_new_old) {
  const Eigen::Matrix3d R = T_new_old.rotation_matrix();
  const bool is_level = !has_height(position.covariance);
  // Turned by the curvature of the Earth, a height of which nothing is known would drown the rest.
  if (is_level) position.covariance(2, 2) = 0.0;
  position.p_enu_antenna = T_new_old * position.p_enu_antenna;
  position.covariance = R * position.covariance * R.transpose();
  if (is_level) position.covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
  if (position.R_enu_base) position.R_enu_base = T_new_old.rotation * *position.R_enu_base;
  return position;
}

}  // namespace lidar_mapping::pipeline
