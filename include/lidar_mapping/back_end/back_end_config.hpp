// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

namespace lidar_mapping::back_end {

/// Which key frames the floor below the vehicle connects.
enum class FloorConstraint {
  kNone,        ///< floors are not used
  kNeighbours,  ///< two successive key frames stand on one plane
  kPlane        ///< all key frames stand on one plane
};

/// Parameters of the back end. schema() describes each of them once; the comments here repeat it.
struct BackEndConfig {
  // What is used.
  /// Whether GNSS positions are used at all.
  bool use_gnss = true;
  /// With use_gnss: GNSS only moves the whole map to East-North-Up, without bending it.
  bool georeference_only = false;
  /// Whether loops are used.
  bool use_loop_close = true;

  // When a solution is due.
  /// [key frames] Optimise at the latest after so many new key frames.
  int optimize_step_with_key_frame = 100;
  /// [positions] Optimise at the latest after so many new GNSS positions.
  int optimize_step_with_gnss = 100;
  /// [loops] Optimise after so many new loops.
  int optimize_step_with_loop = 1;
  /// [s] Least time between optimisations, by the key frames' stamps.
  double optimize_min_interval = 1.0;

  // Odometry.
  /// [fraction of the distance] Upper limit of the standard deviation that drift adds to a motion's
  /// translation. Where positions show less drift, this and the next three are reduced, but not
  /// below a tenth.
  double odometry_drift = 0.005;
  /// [rad/m] Standard deviation that drift adds to a motion's rotation.
  double odometry_rotation_drift = 0.02 * kRadPerDeg;
  /// [m] Added to the covariance of every motion.
  double odometry_min_stddev_m = 0.0025;
  /// [rad] Added to the covariance of every motion.
  double odometry_min_stddev_rad = 0.02 * kRadPerDeg;
  /// [fraction of the distance] Standard deviation added along directions that matching could not
  /// observe.
  double odometry_degenerate_drift = 0.2;

  // Loops.
  /// [m] Added to the covariance of every loop.
  double loop_min_stddev_m = 0.02;
  /// [rad] Added to the covariance of every loop.
  double loop_min_stddev_rad = 0.1 * kRadPerDeg;

  // The first key frame.
  /// Give the first key frame a prior with fix_first_node_stddev, instead of one that depends on
  /// the other constraints.
  bool fix_first_node = false;
  /// [m and rad: x y z roll pitch yaw] With fix_first_node: standard deviations of its pose, in the
  /// axes of base_link.
  std::vector<double> fix_first_node_stddev = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0};

  // Other weights of motions and loops, as in hdl_graph_slam.
  /// Weight all motions and loops by const_stddev_x and const_stddev_q instead of their
  /// covariances.
  bool use_const_inf_matrix = false;
  /// Weight loops by their fitness (var_gain_a, min and max stddevs) instead of their covariances.
  bool use_fitness_inf_matrix = false;
  /// [m] Standard deviation of the translation, with use_const_inf_matrix.
  double const_stddev_x = 0.5;
  /// [half rad] Standard deviation of the vector part of the quaternion, with use_const_inf_matrix.
  double const_stddev_q = 0.1;
  /// [1/m^2] How fast variances grow with the fitness, with use_fitness_inf_matrix.
  double var_gain_a = 20.0;
  /// [m] At fitness zero.
  double min_stddev_x = 0.1;
  /// [m] At inf_matrix_max_fitness.
  double max_stddev_x = 5.0;
  /// [half rad] At fitness zero.
  double min_stddev_q = 0.05;
  /// [half rad] At inf_matrix_max_fitness.
  double max_stddev_q = 0.2;
  /// [m^2] Fitness at which the variances reach their maxima.
  double inf_matrix_max_fitness = 0.5;

  // GNSS.
  /// [m] Least horizontal standard deviation of a GNSS position.
  double gnss_min_stddev_m = 0.05;
  /// [m] Least standard deviation of a GNSS altitude.
  double gnss_min_stddev_altitude_m = 0.1;
  /// [m] Positions with a larger horizontal standard deviation are refused.
  double gnss_max_stddev_m = 10.0;
  /// [m] Fixes closer together have one error in common; their weights are reduced to that of one
  /// fix.
  double gnss_correlation_distance = 10.0;
  /// [m] Least extent of the track before it is aligned to East-North-Up.
  double gnss_alignment_distance = 5.0;
  /// [rad] Largest standard deviation of the heading with which the track is aligned to East-North-
  /// Up.
  double gnss_alignment_stddev = 3.0 * kRadPerDeg;
  /// Correct GNSS stamps that are late or early relative to odometry.
  bool estimate_gnss_time_offset = true;

  // IMU.
  /// Whether the tilt of the IMU's orientation keeps the map level.
  bool enable_imu_orientation = true;
  /// Whether headings that come with GNSS positions are used; only for an IMU with a true heading.
  bool enable_imu_heading = false;
  /// Whether the measured acceleration, as gravity, keeps the map level.
  bool enable_imu_acceleration = false;
  /// [rad] Upper limit of the standard deviation of the tilt at one key frame. It is reduced, but
  /// not below a quarter, where the tilt agrees with odometry.
  double imu_orientation_stddev = 2.0 * kRadPerDeg;
  /// [rad] Standard deviation of the heading at one key frame; larger than that of the IMU, because
  /// neighbours have errors in common.
  double imu_heading_stddev = 2.0 * kRadPerDeg;
  /// [rad] Standard deviation of the vertical by acceleration at one key frame; motion adds to it.
  double imu_acceleration_stddev = 5.0 * kRadPerDeg;

  // Floors.
  /// Floors of successive key frames as one plane each (safe on slopes), or all floors as a single
  /// plane (flat halls).
  FloorConstraint floor_constraint = FloorConstraint::kNone;
  /// [rad] How much the slope of the floor differs from the plane, added to its covariance.
  double floor_stddev_rad = 0.2 * kRadPerDeg;
  /// [m] How much the height of the floor differs from the plane, added to its covariance.
  double floor_stddev_m = 0.02;

  // A new factor has its switch and its standard deviations here, and its kernel below.

  // Robust kernels of all factors.
  /// Kernel of odometry constraints.
  pose_graph::RobustKernel odometry_robust_kernel = pose_graph::RobustKernel::kNone;
  /// Kernel of the loops that are used.
  pose_graph::RobustKernel loop_robust_kernel = pose_graph::RobustKernel::kHuber;
  /// Kernel of the GNSS positions that are used.
  pose_graph::RobustKernel gnss_robust_kernel = pose_graph::RobustKernel::kHuber;
  /// Kernel of orientations, headings and accelerations.
  pose_graph::RobustKernel imu_robust_kernel = pose_graph::RobustKernel::kHuber;
  /// Kernel of floors.
  pose_graph::RobustKernel floor_robust_kernel = pose_graph::RobustKernel::kCauchy;
  /// [standard deviations] Scale of the kernels: larger residuals get less weight.
  double robust_kernel_size = 3.0;

  /// Names, ranges, units and descriptions of all parameters.
  static const config::Schema<BackEndConfig>& schema();
};

}  // namespace lidar_mapping::back_end
