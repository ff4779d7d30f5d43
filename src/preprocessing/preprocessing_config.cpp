// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

#include <cmath>

namespace lidar_mapping::preprocessing {

namespace {

using Config = PreprocessingConfig;
using Schema = config::Schema<Config>;

void add_sensors(Schema& schema) {
  schema.boolean("use_imu", &Config::use_imu, "Use the IMU where there is one.")
      .boolean("use_velocity", &Config::use_velocity, "Use the velocity where there is one.")
      .boolean("use_gnss", &Config::use_gnss, "Use GNSS positions where there are any.")
      .boolean(
          "enable_robot_odometry_init_guess", &Config::enable_robot_odometry_init_guess,
          "Take the velocity from tf, from how base_link moves in robot_odom_frame_id, instead "
          "of from messages: it predicts the motion and compensates that during the scan.")
      .text("robot_odom_frame_id", &Config::robot_odom_frame_id,
            "Frame in which a wheel odometry gives tf the pose of base_link, or which it gives in "
            "base_link; not the frame of this package's own odometry.");
}

void add_time(Schema& schema) {
  schema
      .choice(
          "scan_stamp", &Config::scan_stamp,
          {{"START", ScanStamp::kStart}, {"MIDDLE", ScanStamp::kMiddle}, {"END", ScanStamp::kEnd}},
          "Instant of the scan that its message's stamp names; point times that are never "
          "negative count from the scan's start and are moved accordingly, others and absolute "
          "ones refer to the stamp as they are.")
      .real("scan_period", &Config::scan_period, {0.01, 2.0}, "s", "Time of one turn.")
      .choice(
          "point_times", &Config::point_times,
          {{"FIELD", PointTimes::kField},
           {"AZIMUTH", PointTimes::kAzimuth},
           {"NONE", PointTimes::kNone}},
          "FIELD: point times from the cloud's field, and a scan without it counts as compensated; "
          "AZIMUTH: where there is no field, from the azimuth of the points; NONE: the scans are "
          "compensated already, whatever their fields say.")
      .choice("point_time_unit", &Config::point_time_unit,
              {{"AUTO", PointTimeUnit::kAuto},
               {"S", PointTimeUnit::kSeconds},
               {"MS", PointTimeUnit::kMilliseconds},
               {"US", PointTimeUnit::kMicroseconds},
               {"NS", PointTimeUnit::kNanoseconds}},
              "Unit of the times in the cloud's field; AUTO takes the one that fits scan_period.")
      .choice("scan_direction", &Config::scan_direction,
              {{"CLOCKWISE", ScanDirection::kClockwise},
               {"COUNTERCLOCKWISE", ScanDirection::kCounterclockwise}},
              "How the sensor turns, seen from above (point_times AZIMUTH).")
      .angle("scan_start_azimuth_deg", &Config::scan_start_azimuth, {-360.0, 360.0}, "deg",
             "Azimuth at which a scan begins, from x towards y (point_times AZIMUTH).")
      .real("max_latency", &Config::max_latency, {0.0, 10.0}, "s",
            "How long, in the time of the data, a scan waits for samples of the other sensors.")
      .real("imu_max_gap", &Config::imu_max_gap, {0.001, 10.0}, "s",
            "Longest distance of two IMU samples between which values are interpolated.")
      .real("velocity_max_gap", &Config::velocity_max_gap, {0.001, 10.0}, "s",
            "Longest distance of two velocities between which values are interpolated.")
      .real("gnss_max_gap", &Config::gnss_max_gap, {0.001, 10.0}, "s",
            "Longest distance of two fixes between which positions are interpolated.")
      .real("imu_time_offset", &Config::imu_time_offset, {-10.0, 10.0}, "s",
            "Added to the stamps of the IMU.")
      .real("velocity_time_offset", &Config::velocity_time_offset, {-10.0, 10.0}, "s",
            "Added to the stamps of the velocity.")
      .real("gnss_time_offset", &Config::gnss_time_offset, {-10.0, 10.0}, "s",
            "Added to the stamps of the GNSS fixes.")
      .alias("gps_time_offset", "gnss_time_offset");
}

void add_points(Schema& schema) {
  schema
      .boolean("deskewing", &Config::deskewing,
               "Compensate the motion during the scan by IMU and velocity; without them, or where "
               "this is off, the points keep their times and the front end compensates.")
      .boolean("use_distance_filter", &Config::use_distance_filter, "Cut the points by range.")
      .real("distance_near_thresh", &Config::distance_near_thresh, {0.0, 1000.0}, "m",
            "Nearer points are left out; range from the sensor.")
      .real("distance_far_thresh", &Config::distance_far_thresh, {0.1, 10000.0}, "m",
            "Farther points are left out; range from the sensor.")
      .reals("vehicle_box", &Config::vehicle_box, 6, "m",
             "Points inside are on the vehicle and left out: x, y, z from, x, y, z to, in "
             "base_link; zeros for none.")
      .text("velodyne_calibration", &Config::velodyne_calibration,
            "Calibration file of velodyne_pointcloud (YAML) for packets of a Velodyne; without it "
            "the nominal angles of the model are used, which an HDL-64E does not have.")
      .text("hesai_calibration", &Config::hesai_calibration,
            "Calibration file of Hesai's driver (CSV: channel, elevation, azimuth) for packets of "
            "a Hesai; without it that which the driver records beside the packets is used, or else "
            "the nominal angles of the model.")
      .angle("vertical_angle_correction_deg", &Config::vertical_angle_correction, {-5.0, 5.0},
             "deg", "Turns every beam upwards (0.205 deg for the HDL-64E of KITTI).")
      .choice("downsample_method", &Config::downsample_method,
              {{"NONE", DownsampleMethod::kNone},
               {"VOXELGRID", DownsampleMethod::kVoxelGrid},
               {"APPROX_VOXELGRID", DownsampleMethod::kApproximateVoxelGrid}},
              "Thins the scan: to the mean of each voxel, or (faster) to its first point.")
      .real("downsample_resolution", &Config::downsample_resolution, {0.01, 10.0}, "m",
            "Edge of a voxel.")
      .choice("outlier_removal_method", &Config::outlier_removal_method,
              {{"NONE", OutlierRemovalMethod::kNone},
               {"STATISTICAL", OutlierRemovalMethod::kStatistical},
               {"RADIUS", OutlierRemovalMethod::kRadius}},
              "Leaves out points that stand alone.")
      .integer("statistical_mean_k", &Config::statistical_mean_k, {1, 1000}, "points",
               "Neighbours whose mean distance is judged (STATISTICAL).")
      .real("statistical_stddev", &Config::statistical_stddev, {0.0, 100.0}, "",
            "Allowed mean distance above the scan's mean, in standard deviations (STATISTICAL).")
      .real("radius_radius", &Config::radius_radius, {0.01, 100.0}, "m",
            "Radius in which neighbours are counted (RADIUS).")
      .integer("radius_min_neighbors", &Config::radius_min_neighbors, {1, 1000}, "points",
               "Fewer neighbours make an outlier (RADIUS).")
      .integer("min_points", &Config::min_points, {1, 1000000}, "points",
               "A scan with fewer points after all filters is dropped.");
}

void add_imu(Schema& schema) {
  schema
      .choice("imu_acceleration_unit", &Config::imu_acceleration_unit,
              {{"M_PER_S2", AccelerationUnit::kMetresPerSecond2},
               {"G", AccelerationUnit::kStandardGravity}},
              "Unit of the accelerations in the IMU's messages.")
      .choice("imu_angular_unit", &Config::imu_angular_unit,
              {{"RAD_PER_S", AngularUnit::kRadians}, {"DEG_PER_S", AngularUnit::kDegrees}},
              "Unit of the rates in the IMU's messages.")
      .choice("imu_orientation", &Config::imu_orientation,
              {{"AUTO", ImuOrientation::kAuto},
               {"ENU", ImuOrientation::kEnu},
               {"NONE", ImuOrientation::kNone}},
              "Whether the IMU's orientation has a true heading: AUTO uses it from when the GNSS "
              "track has confirmed it.")
      .boolean("estimate_gyro_bias", &Config::estimate_gyro_bias,
               "Learn the gyro's bias while the vehicle stands.");
}

void add_gnss(Schema& schema) {
  schema
      .integer("gnss_min_status", &Config::gnss_min_status, {0, 2}, "",
               "Least status of a usable fix: 0 any, 1 satellite-based correction, 2 ground-based "
               "correction (RTK).")
      .real("gnss_max_sigma", &Config::gnss_max_sigma, {0.01, 1000.0}, "m",
            "A fix with a larger horizontal standard deviation is refused.")
      .real("gnss_sigma_floor_xy", &Config::gnss_sigma_floor_xy, {0.001, 100.0}, "m",
            "Least horizontal standard deviation that is believed.")
      .real("gnss_sigma_floor_z", &Config::gnss_sigma_floor_z, {0.001, 100.0}, "m",
            "Least vertical standard deviation that is believed.")
      .real("gnss_unknown_sigma_xy", &Config::gnss_unknown_sigma_xy, {0.001, 1000.0}, "m",
            "Horizontal standard deviation of fixes that come without a covariance.")
      .real("gnss_unknown_sigma_z", &Config::gnss_unknown_sigma_z, {0.001, 1000.0}, "m",
            "Vertical standard deviation of fixes that come without a covariance.")
      .boolean("gnss_gating", &Config::gnss_gating,
               "Refuse fixes that contradict the measured motion since the last good ones.")
      .boolean("use_datum", &Config::use_datum,
               "Take `datum` as the map's origin instead of the first good fix.")
      .reals("datum", &Config::datum, 3, "deg, deg, m",
             "Origin of the map: latitude, longitude, height above the ellipsoid.");
}

std::string contradiction(const Config& c) {
  if (c.use_distance_filter && c.distance_near_thresh >= c.distance_far_thresh) {
    return "distance_near_thresh must be less than distance_far_thresh";
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (c.vehicle_box[axis] > c.vehicle_box[axis + 3]) {
      return "vehicle_box: the first three numbers are the lower corner; swap them";
    }
  }
  if (c.enable_robot_odometry_init_guess && c.robot_odom_frame_id.empty()) {
    return "enable_robot_odometry_init_guess needs robot_odom_frame_id";
  }
  if (c.use_datum && (std::abs(c.datum[0]) > 90.0 || std::abs(c.datum[1]) > 180.0)) {
    return "datum: latitude within 90 and longitude within 180 degrees";
  }
  return "";
}

}  // namespace

const config::Schema<PreprocessingConfig>& PreprocessingConfig::schema() {
  static const auto schema = [] {
    Schema result("preprocessing",
                  "Preprocessing: synchronisation, motion compensation, filters, GNSS to local.");
    add_sensors(result);
    add_time(result);
    add_points(result);
    add_imu(result);
    add_gnss(result);
    result.check(contradiction);
    return result;
  }();
  return schema;
}

}  // namespace lidar_mapping::preprocessing
