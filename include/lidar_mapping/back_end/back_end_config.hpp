#pragma once

#include <vector>

#include "lidar_mapping/back_end/robust_kernel.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::back_end {

/// What the floor below the vehicle ties together.
enum class FloorConstraint { kNone, kNeighbours, kPlane };

/// Parameters of the stage; each is described once, in schema().
struct BackEndConfig {
  bool use_gnss = true;
  bool georeference_only = false;
  bool use_loop_close = true;

  int optimize_step_with_key_frame = 100;
  int optimize_step_with_gnss = 100;
  int optimize_step_with_loop = 1;
  double optimize_min_interval = 1.0;

  double odometry_drift = 0.005;
  double odometry_drift_deg_per_m = 0.02;
  double odometry_min_stddev_m = 0.0025;
  double odometry_min_stddev_deg = 0.02;
  double odometry_degenerate_drift = 0.2;
  double loop_min_stddev_m = 0.02;
  double loop_min_stddev_deg = 0.1;

  bool fix_first_node = false;
  /// x, y, z in m; roll, pitch, yaw in rad; in the axes of base_link.
  std::vector<double> fix_first_node_stddev = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0};

  bool use_const_inf_matrix = false;
  bool use_fitness_inf_matrix = false;
  double const_stddev_x = 0.5;
  double const_stddev_q = 0.1;
  double var_gain_a = 20.0;
  double min_stddev_x = 0.1;
  double max_stddev_x = 5.0;
  double min_stddev_q = 0.05;
  double max_stddev_q = 0.2;
  double inf_matrix_max_fitness = 0.5;

  double gnss_min_stddev_m = 0.05;
  double gnss_min_stddev_altitude_m = 0.1;
  double gnss_max_stddev_m = 10.0;
  double gnss_correlation_distance = 10.0;
  double gnss_alignment_distance = 5.0;
  double gnss_alignment_stddev_deg = 3.0;
  bool estimate_gnss_time_offset = true;

  bool enable_imu_orientation = true;
  bool enable_imu_heading = false;
  bool enable_imu_acceleration = false;
  double imu_orientation_stddev_deg = 2.0;
  double imu_heading_stddev_deg = 2.0;
  double imu_acceleration_stddev_deg = 5.0;

  FloorConstraint floor_constraint = FloorConstraint::kNone;
  double floor_stddev_deg = 0.2;
  double floor_stddev_m = 0.02;

  RobustKernel odometry_robust_kernel = RobustKernel::kNone;
  RobustKernel loop_robust_kernel = RobustKernel::kHuber;
  RobustKernel gnss_robust_kernel = RobustKernel::kHuber;
  RobustKernel imu_robust_kernel = RobustKernel::kHuber;
  RobustKernel floor_robust_kernel = RobustKernel::kCauchy;
  double robust_kernel_size = 3.0;

  static const config::Schema<BackEndConfig>& schema();
};

}  // namespace lidar_mapping::back_end
