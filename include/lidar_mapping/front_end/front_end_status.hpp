// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/front_end/step_evidence.hpp"
#include "lidar_mapping/front_end/sweep_times.hpp"

namespace lidar_mapping::front_end {

/// What the front end claims about the pose of a scan.
enum class TrackingState {
  kTracking,  ///< the match is good
  /// the match is good, but some directions were not observed: they follow the prediction
  kDegenerate,
  kDoubtful,  ///< the match is good, but the step may be wrong by more than 0.3 m or 1 degree
  /// the match is poor or probably wrong: it is used, but the scan is not put into the map
  kDegraded,
  kLost  ///< no acceptable match: the pose is the prediction
};
/// "tracking", "degenerate", "doubtful", "degraded", "lost".
const char* to_string(TrackingState state);
/// True if the state claims that the pose is correct within its covariance.
bool claims_pose(TrackingState state);

/// The quality of one scan's match, and what was observed with it.
struct FrontEndStatus {
  TrackingState state = TrackingState::kTracking;  ///< the judgement in one word
  bool converged = false;        ///< the search ended before its iterations ran out
  int iterations = 0;            ///< steps of the search
  double fitness = 0.0;          ///< mean squared distance of paired points, m^2
  double inlier_fraction = 0.0;  ///< points that the robust kernel believes, 0 to 1
  double overlap = 0.0;          ///< points with a partner in the map, 0 to 1
  std::vector<Eigen::Vector3d> degenerate_directions;  ///< unit length, in base_link
  bool rescued = false;  ///< the match needed more than one starting pose
  /// the points are the same as those of the previous scan, as from a driver that hangs
  bool repeated = false;
  /// Number of points since the start that were not inserted because the local map was full. Later
  /// scans cannot be matched against them.
  std::size_t map_points_dropped = 0;
  /// Standard deviation (m) of the distance travelled since the start, as far as it comes from
  /// directions that neither the points nor other sensors observed (UnobservedTravel). It grows
  /// while the state is degenerate.
  double unobserved_stddev = 0.0;
  /// Error of the sensor's elevation angles, rad, as estimated: the points are rotated upwards by
  /// this angle, in steps that are too small to disturb a match.
  double elevation_shift = 0.0;
  /// Standard deviation of the stamps, s, if they are so irregular that whole turns of the sensor
  /// are counted instead (SweepClock); otherwise 0.
  double stamp_jitter = 0.0;
  /// Where the times of the points come from; other than as given if these were found wrong
  /// (SweepTimesValidator).
  SweepTimesRule sweep_times;
  /// The gyro predicts the matches worse than a prediction without it does, so it is not used
  /// (GyroValidator).
  bool gyro_distrusted = false;
  /// The measured velocity is off by half of the matched speed (VelocityValidator).
  bool velocity_distrusted = false;
  /// Vertical distance travelled so far according to the accelerometer alone, m: the points did not
  /// show this motion (VerticalRideDetector).
  double vertical_ride_distance = 0.0;
  /// Probability, 0 to 1, that the step from the last scan with a claimed pose is correct within
  /// three of its own standard deviations (StepBelief).
  double probability = 1.0;
  /// Usual error of such a step, independent of its covariance; 0 if nothing was matched.
  double expected_error = 0.0;        ///< m
  double expected_error_angle = 0.0;  ///< rad
  /// The figures from which probability and expected errors are computed.
  StepEvidence evidence;
  /// Computing time of the whole scan, s. It and those of the steps are the only figures that
  /// differ from run to run.
  double seconds = 0.0;
  std::vector<std::pair<std::string, double>> step_seconds;  ///< name and s of each step
};

/// The message that points are rotated upwards by `elevation_shift` (rad) from now on.
std::string elevation_message(double elevation_shift);

}  // namespace lidar_mapping::front_end
