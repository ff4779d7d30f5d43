#pragma once

#include "lidar_mapping/back_end/robust_kernel.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::back_end {

/// Parameters of the stage; each is described once, in schema().
struct BackEndConfig {
  bool use_gnss = true;
  bool georeference_only = false;
  bool use_loop_close = true;

  int optimize_step_with_key_frame = 100;
  int optimize_step_with_gnss = 100;
  int optimize_step_with_loop = 1;
  double optimize_min_interval = 1.0;

  double odometry_drift = 0.01;
  double odometry_drift_deg_per_m = 0.02;
  double odometry_min_stddev_m = 0.005;
  double odometry_min_stddev_deg = 0.02;
  double odometry_degenerate_drift = 0.2;
  double loop_min_stddev_m = 0.02;
  double loop_min_stddev_deg = 0.1;

  double gnss_min_stddev_m = 0.05;
  double gnss_min_stddev_altitude_m = 0.1;
  double gnss_max_stddev_m = 10.0;
  double gnss_correlation_distance = 10.0;
  double gnss_alignment_distance = 20.0;
  double gnss_alignment_stddev_deg = 1.0;

  RobustKernel odometry_robust_kernel = RobustKernel::kNone;
  RobustKernel loop_robust_kernel = RobustKernel::kHuber;
  RobustKernel gnss_robust_kernel = RobustKernel::kHuber;
  double robust_kernel_size = 3.0;

  static const config::Schema<BackEndConfig>& schema();
};

}  // namespace lidar_mapping::back_end
