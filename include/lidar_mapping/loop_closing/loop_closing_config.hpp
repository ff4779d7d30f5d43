// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::loop_closing {

/// How the points of a cloud are thinned before matching.
enum class FilterMethod {
  kVoxel,  ///< mean of the points in each voxel
  kNone    ///< all points
};

/// The registration method that aligns a scan with a submap: the point-to-plane method of this
/// stage, or a method of the stage registration.
struct LoopMethod {
  bool point_to_plane = true;  ///< use the point-to-plane method of this stage
  registration::Method other = registration::Method::kNdt;  ///< method used otherwise

  /// True if both name the same method.
  friend bool operator==(const LoopMethod& a, const LoopMethod& b) {
    return a.point_to_plane == b.point_to_plane && (a.point_to_plane || a.other == b.other);
  }
};

/// Parameters of loop closing. schema() describes each of them once; the comments here repeat it.
struct LoopClosingConfig {
  // When to search.
  /// [key frames] Search at most every so many key frames.
  int loop_step = 2;
  /// [m] Distance to travel after an accepted loop before the next search; below 0 by the range of
  /// sight.
  double min_edge_interval = -1.0;
  // Where to search.
  /// Candidates from the newest estimate of the trajectory.
  bool position_candidates = true;
  /// Candidates from GNSS positions.
  bool gnss_candidates = true;
  /// Candidates from the appearance of the surroundings from above.
  bool appearance_candidates = true;
  /// [key frames] Least gap between the indices of two key frames of a loop.
  int diff_num = 15;
  /// [m] Least distance travelled between two key frames of a loop; below 0 by the range of sight.
  double accum_distance_thresh = -1.0;
  /// [m] Radius of the search where positions are certain; it grows with the uncertainty.
  double detect_area = 10.0;
  /// [m] Limit of the radius of the search, however uncertain the positions are.
  double distance_thresh = 1000.0;
  /// [m/m] Standard deviation of the estimate's horizontal drift per distance travelled.
  double horizontal_drift = 0.01;
  /// [m/m] Standard deviation of the height after 1 km; it grows with the power 1.5 of the
  /// distance.
  double vertical_drift = 0.003;
  /// [rad/m] Standard deviation of the estimate's rotation drift per distance travelled.
  double rotation_drift = 1.0 * kRadPerDeg / 100.0;
  /// How many of the best candidates of one search are matched at most; if the estimate is certain
  /// to about a metre, the first accepted one ends the search.
  int max_registrations = 2;
  // What to match.
  /// [key frames] The submap of an old key frame reaches so many key frames to either side.
  int extend_frame_num = 5;
  /// How the submap is thinned.
  FilterMethod map_filter = FilterMethod::kVoxel;
  /// How the newest scan is thinned.
  FilterMethod scan_filter = FilterMethod::kVoxel;
  /// [m] Edge of the submap's voxels.
  double map_leaf_size = 0.4;
  /// [m] Edge of the scan's voxels.
  double scan_leaf_size = 0.4;
  /// How a scan is aligned with a submap: POINT_TO_PLANE is the package's own method for loops,
  /// from coarse to fine; the reg_ parameters are for the others.
  LoopMethod registration_method;
  /// Parameters of the other methods; its method and range of fitness are not used.
  registration::RegistrationConfig registration;
  // What to accept.
  /// [m] Key frames that are further apart have too little overlap for a loop; below 0 by the range
  /// of sight, and more overlap is asked of those that are not close.
  double max_loop_distance = 7.5;
  /// The overlap above ground minus twice the free-space violation of a loop must be larger than
  /// this.
  double overlap_margin_limit = 0.5;
  /// The horizontal eigenvalue of a loop must be larger than this: walls determine it in all
  /// directions.
  double eigenvalue_limit = 0.02;
  /// [points] With fewer points above ground a candidate stays undecided.
  int min_tested_points = 300;
  /// Largest squared distance from the estimate in units of its covariance.
  double innovation_limit = 22.5;
  /// [m^2] Largest mean squared distance of paired points; 0 leaves this figure out.
  double fitness_score_limit = 1.0;
  /// [m] Points without a partner within this range do not count in the fitness.
  double fitness_score_max_range = 2.0;
  /// [m] Two unconnected segments are connected once loops agree over such a path length.
  double unanchored_path_length = 100.0;
  /// [m] Lower limit of a loop's standard deviation in translation.
  double min_stddev_x = 0.05;
  /// [rad] Lower limit of a loop's standard deviation in rotation.
  double min_stddev_q = 0.002;

  /// Edge of the voxels by which a submap is thinned, m; 0 keeps all points.
  double map_leaf() const { return map_filter == FilterMethod::kVoxel ? map_leaf_size : 0.0; }
  /// Edge of the voxels by which a scan is thinned, m; 0 keeps all points.
  double scan_leaf() const { return scan_filter == FilterMethod::kVoxel ? scan_leaf_size : 0.0; }

  /// Names, ranges, units and descriptions of all parameters.
  static const config::Schema<LoopClosingConfig>& schema();
};

}  // namespace lidar_mapping::loop_closing
