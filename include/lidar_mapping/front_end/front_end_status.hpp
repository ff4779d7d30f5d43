// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/front_end/step_evidence.hpp"

namespace lidar_mapping::front_end {

enum class TrackingState {
  kTracking,
  kDegenerate,  ///< fits, but some directions were not observed: they follow the prediction
  kDoubtful,    ///< fits, but the step may be off by more than 0.3 m or 1 degree
  kDegraded,    ///< fits poorly, or is probably wrong: used, but not put into the map
  kLost         ///< does not fit: the pose is the prediction
};
/// "tracking", "degenerate", "doubtful", "degraded", "lost".
const char* to_string(TrackingState state);
/// True if the pose is said to be right within its covariance.
bool claims_pose(TrackingState state);

/// How one scan was judged.
struct FrontEndStatus {
  TrackingState state = TrackingState::kTracking;
  bool converged = false;
  int iterations = 0;
  double fitness = 0.0;          ///< mean squared distance of paired points, m^2
  double inlier_fraction = 0.0;  ///< 0 to 1
  double overlap = 0.0;          ///< 0 to 1
  std::vector<Eigen::Vector3d> degenerate_directions;  ///< in base_link
  bool rescued = false;                                ///< more than one start was needed
  bool repeated = false;  ///< the points are those of the scan before, as of a driver that hangs
  /// Points since the beginning that the local map had no room for: it is full, and what is new to
  /// it is not matched against later.
  std::size_t map_points_dropped = 0;
  /// Standard deviation (m) of the way since the beginning that comes from directions that neither
  /// the points nor other sensors observed (UnobservedTravel): it grows where the state is
  /// degenerate.
  double unobserved_stddev = 0.0;
  /// What the sensor's elevations were found to lack, rad: points are turned upwards by that, in
  /// steps that no match feels.
  double elevation_shift = 0.0;
  /// Scatter of the stamps, s, where they are so irregular that turns of the sensor are counted
  /// instead (SweepClock); 0 elsewhere.
  double stamp_jitter = 0.0;
  /// The gyro foretells matches worse than they foretell each other, and is not used
  /// (GyroValidator).
  bool gyro_distrusted = false;
  /// What the sensor went up or down so far by the accelerometer alone, m: no points showed it
  /// (VerticalRideDetector).
  double unseen_way = 0.0;
  /// That the step from the last scan that claimed its pose is right within three of its own
  /// standard deviations, 0 to 1 (StepBelief).
  double probability = 1.0;
  /// How far off such a step usually is, whatever its covariance says; 0 where nothing was matched.
  double expected_error = 0.0;        ///< m
  double expected_error_angle = 0.0;  ///< rad
  /// What these follow from.
  StepEvidence evidence;
  /// For whole scan and for its steps: the only figures that are not the same in each run.
  double seconds = 0.0;
  std::vector<std::pair<std::string, double>> step_seconds;
};

/// Says that points are turned upwards by `elevation_shift` (rad) from now on.
std::string elevation_notice(double elevation_shift);
/// Says that the local map is full, and what makes room.
std::string full_map_notice(std::size_t map_points_dropped);
/// Says that stamps scatter by `jitter` (s) and what is done about it.
std::string jitter_notice(double jitter);
/// Says that the sensor rides up or down without any points that show it.
std::string ride_notice();
/// Says that the gyro is not used to predict, and what to look at.
std::string gyro_notice();

}  // namespace lidar_mapping::front_end
