#pragma once

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::loop_closing {

/// How the points of a cloud are thinned before matching.
enum class FilterMethod { kVoxel, kNone };

/// How a scan is aligned with a submap: this package's own point-to-plane registration, or one of
/// the methods of the stage registration.
struct LoopMethod {
  bool point_to_plane = true;
  registration::Method other = registration::Method::kNdt;

  friend bool operator==(const LoopMethod& a, const LoopMethod& b) {
    return a.point_to_plane == b.point_to_plane && (a.point_to_plane || a.other == b.other);
  }
};

/// Parameters of the stage; each is described once, in schema().
struct LoopClosingConfig {
  // When to search.
  int loop_step = 2;
  double min_edge_interval = 5.0;
  // Where to search.
  bool position_candidates = true;
  bool gnss_candidates = true;
  bool appearance_candidates = true;
  int diff_num = 15;
  double accum_distance_thresh = 50.0;
  double detect_area = 10.0;
  double distance_thresh = 1000.0;
  double horizontal_drift = 0.01;
  double vertical_drift = 0.003;
  double rotation_drift_deg = 1.0;
  int max_registrations = 2;
  // What to match.
  int extend_frame_num = 5;
  FilterMethod map_filter = FilterMethod::kVoxel;
  FilterMethod scan_filter = FilterMethod::kVoxel;
  double map_leaf_size = 0.4;
  double scan_leaf_size = 0.4;
  LoopMethod registration_method;
  /// Parameters of the other methods; its method and range of fitness are not used.
  registration::RegistrationConfig registration;
  // What to believe.
  double max_loop_distance = 7.5;
  double overlap_margin_limit = 0.5;
  double eigenvalue_limit = 0.02;
  int min_tested_points = 300;
  double innovation_limit = 22.5;
  double fitness_score_limit = 1.0;
  double fitness_score_max_range = 2.0;
  double unanchored_stretch = 100.0;
  double min_stddev_x = 0.05;
  double min_stddev_q = 0.002;

  static const config::Schema<LoopClosingConfig>& schema();
};

}  // namespace lidar_mapping::loop_closing
