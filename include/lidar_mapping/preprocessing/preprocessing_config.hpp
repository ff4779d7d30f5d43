// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::preprocessing {

/// Source of the points' times.
enum class PointTimes {
  kField,    ///< from the cloud's field; a scan without this field is taken as motion-compensated
  kAzimuth,  ///< from the direction of the points, if there is no field
  kNone      ///< the scan is motion-compensated already, even if it has a time field
};
/// Unit of the times in a cloud's field.
enum class PointTimeUnit {
  kAuto,          ///< the one in which they span about a turn
  kSeconds,       ///< s
  kMilliseconds,  ///< ms
  kMicroseconds,  ///< us
  kNanoseconds    ///< ns
};
/// How the sensor turns.
enum class ScanDirection {
  kClockwise,        ///< seen from above
  kCounterclockwise  ///< seen from above
};
/// The instant of a scan to which the stamp of its message refers.
enum class ScanStamp {
  kStart,   ///< that of its first point
  kMiddle,  ///< half a scan_period after the start
  kEnd      ///< a scan_period after the start
};
/// How a scan is thinned.
enum class DownsampleMethod {
  kNone,                 ///< not at all
  kVoxelGrid,            ///< to the mean of each voxel
  kApproximateVoxelGrid  ///< to the first point of each voxel
};
/// Which points count as outliers.
enum class OutlierRemovalMethod {
  kNone,         ///< none
  kStatistical,  ///< those whose mean distance to their neighbours is large for the scan
  kRadius        ///< those with few neighbours within a radius
};
/// Whether the orientation of the IMU refers to East-North-Up.
enum class ImuOrientation {
  kAuto,  ///< if its heading agrees with the track of the GNSS positions
  kEnu,   ///< always
  kNone   ///< never
};
/// Unit of accelerations.
enum class AccelerationUnit {
  kMetresPerSecond2,  ///< m/s^2
  kStandardGravity    ///< g, see lidar_mapping::kStandardGravity
};
/// Factor from the unit to m/s^2.
inline double si_factor(AccelerationUnit unit) {
  return unit == AccelerationUnit::kStandardGravity ? kStandardGravity : 1.0;
}
/// Unit of angular rates.
enum class AngularUnit {
  kRadians,  ///< rad/s
  kDegrees   ///< degrees per second
};
/// Factor from the unit to rad/s.
inline double si_factor(AngularUnit unit) {
  return unit == AngularUnit::kDegrees ? kRadPerDeg : 1.0;
}

/// Parameters of the stage; each is described once, in schema().
struct PreprocessingConfig {
  /// Use the IMU where there is one.
  bool use_imu = true;
  /// Use the velocity where there is one.
  bool use_velocity = true;
  /// Use GNSS positions where there are any.
  bool use_gnss = true;
  /// Take the velocity from tf, from how base_link moves in robot_odom_frame_id, instead of from
  /// messages: it predicts the motion and compensates that during the scan.
  bool enable_robot_odometry_init_guess = false;
  /// Frame in which a wheel odometry gives tf the pose of base_link, or which it gives in
  /// base_link; not the frame of this package's own odometry.
  std::string robot_odom_frame_id = "robot_odom";

  // Time
  /// Instant of the scan that its message's stamp names; point times that are never negative count
  /// from the scan's start and are moved accordingly, others and absolute ones refer to the stamp
  /// as they are.
  ScanStamp scan_stamp = ScanStamp::kStart;
  /// [s] Time of one turn.
  double scan_period = 0.1;
  /// FIELD: point times from the cloud's field, and a scan without it counts as compensated;
  /// AZIMUTH: where there is no field, from the azimuth of the points; NONE: the scans are
  /// compensated already, whatever their fields say.
  PointTimes point_times = PointTimes::kField;
  /// Unit of the times in the cloud's field; AUTO takes the one that fits scan_period.
  PointTimeUnit point_time_unit = PointTimeUnit::kAuto;
  /// How the sensor turns, seen from above (point_times AZIMUTH).
  ScanDirection scan_direction = ScanDirection::kClockwise;
  /// [rad] Azimuth at which a scan begins, from x towards y (point_times AZIMUTH).
  double scan_start_azimuth = 180.0 * kRadPerDeg;
  /// [s] How long, in the time of the data, a scan waits for samples of the other sensors.
  double max_latency = 0.3;
  /// [s] Longest distance of two IMU samples between which values are interpolated.
  double imu_max_gap = 0.25;
  /// [s] Longest distance of two velocities between which values are interpolated.
  double velocity_max_gap = 0.25;
  /// [s] Longest distance of two fixes between which positions are interpolated.
  double gnss_max_gap = 1.1;
  /// [s] Added to the stamps of the IMU.
  double imu_time_offset = 0.0;
  /// [s] Added to the stamps of the velocity.
  double velocity_time_offset = 0.0;
  /// [s] Added to the stamps of the GNSS fixes.
  double gnss_time_offset = 0.0;

  // Points
  /// Compensate the motion during the scan by IMU and velocity; without them, or where this is off,
  /// the points keep their times and the front end compensates.
  bool deskewing = true;
  /// Cut the points by range.
  bool use_distance_filter = true;
  /// [m] Nearer points are left out; range from the sensor.
  double distance_near_thresh = 1.0;
  /// [m] Farther points are left out; range from the sensor.
  double distance_far_thresh = 200.0;
  /// [m] Points inside are on the vehicle and left out: x, y, z from, x, y, z to, in base_link;
  /// zeros for none.
  std::vector<double> vehicle_box = std::vector<double>(6, 0.0);
  /// Calibration file of velodyne_pointcloud (YAML) for packets of a Velodyne; without it the
  /// nominal angles of the model are used, which an HDL-64E does not have.
  std::string velodyne_calibration;
  /// Calibration file of Hesai's driver (CSV: channel, elevation, azimuth) for packets of a Hesai;
  /// without it that which the driver records beside the packets is used, or else the nominal
  /// angles of the model.
  std::string hesai_calibration;
  /// [rad] Turns every beam upwards (0.205 deg for the HDL-64E of KITTI).
  double vertical_angle_correction = 0.0;
  /// Thins the scan: to the mean of each voxel, or (faster) to its first point.
  DownsampleMethod downsample_method = DownsampleMethod::kNone;
  /// [m] Edge of a voxel.
  double downsample_resolution = 0.1;
  /// Leaves out points that stand alone.
  OutlierRemovalMethod outlier_removal_method = OutlierRemovalMethod::kNone;
  /// [points] Neighbours whose mean distance is judged (STATISTICAL).
  int statistical_mean_k = 20;
  /// Allowed mean distance above the scan's mean, in standard deviations (STATISTICAL).
  double statistical_stddev = 1.0;
  /// [m] Radius in which neighbours are counted (RADIUS).
  double radius_radius = 0.8;
  /// [points] Fewer neighbours make an outlier (RADIUS).
  int radius_min_neighbors = 2;
  /// [points] A scan with fewer points after all filters is dropped.
  int min_points = 50;

  // IMU
  /// Unit of the accelerations in the IMU's messages.
  AccelerationUnit imu_acceleration_unit = AccelerationUnit::kMetresPerSecond2;
  /// Unit of the rates in the IMU's messages.
  AngularUnit imu_angular_unit = AngularUnit::kRadians;
  /// Whether the IMU's orientation has a true heading: AUTO uses it from when the GNSS track has
  /// confirmed it.
  ImuOrientation imu_orientation = ImuOrientation::kAuto;
  /// Learn the gyro's bias while the vehicle stands.
  bool estimate_gyro_bias = true;

  // GNSS
  /// Least status of a usable fix: 0 any, 1 satellite-based correction, 2 ground-based correction
  /// (RTK).
  int gnss_min_status = 0;
  /// [m] A fix with a larger horizontal standard deviation is refused.
  double gnss_max_sigma = 15.0;
  /// [m] Least horizontal standard deviation that is believed.
  double gnss_sigma_floor_xy = 0.05;
  /// [m] Least vertical standard deviation that is believed.
  double gnss_sigma_floor_z = 0.1;
  /// [m] Horizontal standard deviation of fixes that come without a covariance.
  double gnss_unknown_sigma_xy = 3.0;
  /// [m] Vertical standard deviation of fixes that come without a covariance.
  double gnss_unknown_sigma_z = 6.0;
  /// Refuse fixes that contradict the measured motion since the last good ones.
  bool gnss_gating = true;
  /// Take `datum` as the map's origin instead of the first good fix.
  bool use_datum = false;
  /// [deg, deg, m] Origin of the map: latitude, longitude, height above the ellipsoid.
  std::vector<double> datum = std::vector<double>(3, 0.0);

  /// All fields, and checks between them.
  static const config::Schema<PreprocessingConfig>& schema();
};

}  // namespace lidar_mapping::preprocessing
