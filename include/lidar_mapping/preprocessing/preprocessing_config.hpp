#pragma once

#include <string>
#include <vector>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::preprocessing {

/// Where the time of a point comes from.
enum class PointTimes {
  kField,    ///< from the cloud's field; without one the scan counts as compensated
  kAzimuth,  ///< where there is no field, from the direction of the points
  kNone      ///< the scan is compensated already, whatever its fields say
};
/// Unit of the times in a cloud's field.
enum class PointTimeUnit { kAuto, kSeconds, kMilliseconds, kMicroseconds, kNanoseconds };
enum class ScanDirection { kClockwise, kCounterclockwise };
/// The instant of a scan that the stamp of its message names.
enum class ScanStamp { kStart, kMiddle, kEnd };
enum class DownsampleMethod { kNone, kVoxelGrid, kApproximateVoxelGrid };
enum class OutlierRemovalMethod { kNone, kStatistical, kRadius };
/// Whether the orientation of the IMU is one in East-North-Up.
enum class ImuOrientation {
  kAuto,  ///< if its heading agrees with the track of the GNSS positions
  kEnu,   ///< always
  kNone   ///< never
};
enum class AccelerationUnit { kMetresPerSecond2, kStandardGravity };
enum class AngularUnit { kRadians, kDegrees };

/// Parameters of the stage; each is described once, in schema().
struct PreprocessingConfig {
  bool use_imu = true;
  bool use_velocity = true;
  bool use_gnss = true;
  /// The velocity comes from how tf's transform between this frame and base_link changes.
  bool enable_robot_odometry_init_guess = false;
  std::string robot_odom_frame_id = "robot_odom";

  // Time
  ScanStamp scan_stamp = ScanStamp::kStart;
  double scan_period = 0.1;
  PointTimes point_times = PointTimes::kField;
  PointTimeUnit point_time_unit = PointTimeUnit::kAuto;
  ScanDirection scan_direction = ScanDirection::kClockwise;
  double scan_start_azimuth_deg = 180.0;
  double max_latency = 0.3;
  double imu_max_gap = 0.25;
  double velocity_max_gap = 0.25;
  double gnss_max_gap = 1.1;
  double imu_time_offset = 0.0;
  double velocity_time_offset = 0.0;
  double gnss_time_offset = 0.0;

  // Points
  bool deskewing = true;
  bool use_distance_filter = true;
  double distance_near_thresh = 1.0;
  double distance_far_thresh = 200.0;
  std::vector<double> vehicle_box = std::vector<double>(6, 0.0);
  double vertical_angle_correction_deg = 0.0;
  DownsampleMethod downsample_method = DownsampleMethod::kNone;
  double downsample_resolution = 0.1;
  OutlierRemovalMethod outlier_removal_method = OutlierRemovalMethod::kNone;
  int statistical_mean_k = 20;
  double statistical_stddev = 1.0;
  double radius_radius = 0.8;
  int radius_min_neighbors = 2;
  int min_points = 50;

  // IMU
  AccelerationUnit imu_acceleration_unit = AccelerationUnit::kMetresPerSecond2;
  AngularUnit imu_angular_unit = AngularUnit::kRadians;
  ImuOrientation imu_orientation = ImuOrientation::kAuto;
  bool estimate_gyro_bias = true;

  // GNSS
  int gnss_min_status = 0;
  double gnss_max_sigma = 15.0;
  double gnss_sigma_floor_xy = 0.05;
  double gnss_sigma_floor_z = 0.1;
  double gnss_unknown_sigma_xy = 3.0;
  double gnss_unknown_sigma_z = 6.0;
  bool gnss_gating = true;
  bool use_datum = false;
  std::vector<double> datum = std::vector<double>(3, 0.0);

  static const config::Schema<PreprocessingConfig>& schema();
};

}  // namespace lidar_mapping::preprocessing
