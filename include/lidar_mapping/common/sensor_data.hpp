// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// Inertial measurement; the frame is that of the sensor or base_link, as the owner documents.
struct ImuSample {
  Stamp stamp = 0;                                             ///< of the measurement
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d linear_acceleration =
      Eigen::Vector3d::Zero();                    ///< m/s^2, +g upward at rest (REP 145)
  std::optional<Eigen::Quaterniond> orientation;  ///< R_world_sensor, East-North-Up
  // Quantities that the sensor does not measure are zero here; that does not mean standstill.
  bool has_angular_velocity = true;     ///< false: the sensor has no gyro
  bool has_linear_acceleration = true;  ///< false: the sensor has no accelerometer
};

/// Velocity of a frame in its own axes.
struct VelocitySample {
  Stamp stamp = 0;                                    ///< of the measurement
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rad/s
};

/// A fix as the receiver reports it.
struct GnssFix {
  Stamp stamp = 0;             ///< of the measurement, as the receiver has it
  double latitude_deg = 0.0;   ///< of the antenna, WGS 84, north positive
  double longitude_deg = 0.0;  ///< of the antenna, WGS 84, east positive
  double altitude_m = 0.0;     ///< above the WGS 84 ellipsoid; NaN if unknown
  int status = -1;             ///< sensor_msgs/NavSatStatus: -1 none, 0 fix, 1 SBAS, 2 GBAS (RTK)
  std::optional<Eigen::Matrix3d> covariance;  ///< m^2, East-North-Up; none if unknown
};

/// Origin of the local East-North-Up frame.
struct GeodeticDatum {
  double latitude_deg = 0.0;   ///< WGS 84, north positive
  double longitude_deg = 0.0;  ///< WGS 84, east positive
  double altitude_m = 0.0;     ///< above the WGS 84 ellipsoid

  /// Equal to the last bit.
  bool operator==(const GeodeticDatum& other) const {
    return latitude_deg == other.latitude_deg && longitude_deg == other.longitude_deg &&
           altitude_m == other.altitude_m;
  }
};

/// Standard deviation (m) of a horizontal coordinate, the root mean square of east and north, of a
/// position with this covariance (m^2, East-North-Up).
inline double horizontal_stddev(const Eigen::Matrix3d& covariance) {
  return std::sqrt(0.5 * covariance.topLeftCorner<2, 2>().trace());
}

/// Position of the antenna in the local East-North-Up frame at a scan's stamp.
struct GnssPosition {
  Stamp stamp = 0;                                           ///< that of the scan
  Eigen::Vector3d p_enu_antenna = Eigen::Vector3d::Zero();   ///< m, from the datum
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, East-North-Up
  Eigen::Vector3d p_base_antenna = Eigen::Vector3d::Zero();  ///< lever arm, m
  std::optional<Eigen::Quaterniond> R_enu_base;              ///< where an IMU gives a true heading

  /// Position of base_link in East-North-Up, m, if it has this orientation there.
  Eigen::Vector3d p_enu_base(const Eigen::Quaterniond& R_enu_base_there) const {
    return p_enu_antenna - R_enu_base_there * p_base_antenna;
  }
  /// Pose of base_link in East-North-Up; empty if the heading is not known.
  std::optional<Pose> T_enu_base() const {
    if (!R_enu_base) return std::nullopt;
    return Pose{*R_enu_base, p_enu_base(*R_enu_base)};
  }
};

}  // namespace lidar_mapping
