// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::back_end {

/// What an optimisation did; the answer of /optimize_map.
struct OptimizationReport {
  bool success = false;
  std::string message;
  std::size_t key_frames = 0;
  std::size_t loops_used = 0;
  std::size_t loops_refused = 0;
  std::size_t gnss_used = 0;
  std::size_t gnss_refused = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
  int iterations = 0;
  double gnss_rms = 0.0;  ///< m, horizontally, of the newest alignment to East-North-Up
  /// Of the information matrix, after a thorough solution (least_eigenvalue.hpp): how firmly the
  /// least known motion of the map is held; 0: not computed, or not held at all.
  double least_eigenvalue = 0.0;
  double seconds = 0.0;  ///< filled in by the caller of solve(); the core owns no clock
  /// What a person has to know of the map beside the figures; no full stop at the end.
  std::vector<std::string> remarks;
};

/// Everything that solve() needs, as a value: a worker thread solves it while sensor data go on.
struct OptimizationProblem;
/// What solve() found.
struct OptimizationSolution;

/// Builds the pose graph of a drive and keeps its poses. Constraints come from odometry, loops,
/// GNSS, IMU and floor; each can be switched off. The graph is solved outside of this object:
///
///   auto solution = solve(back_end.problem());   // long, in a worker thread
///   KeyFramePoses moved = back_end.apply(solution);
///
/// What arrived between the two calls is kept and moved along. One thread at a time calls it.
class BackEnd {
 public:
  explicit BackEnd(const BackEndConfig& config);
  ~BackEnd();

  /// Indices must increase; throws InputError otherwise. Its pose follows odometry from the newest
  /// optimised pose.
  void add_key_frame(const KeyFrame& key_frame);
  /// False (and nothing is changed) if an index is unknown or both are the same.
  bool add_loop(const Loop& loop);
  /// Measurements at the stamp of a key frame, before or after the key frame itself; others are
  /// kept for a while and then forgotten.
  void add_gnss(const GnssPosition& position);
  void add_imu(const ImuSample& sample_base);
  void add_floor(const Floor& floor);

  /// True when one of the optimise steps of the configuration is reached.
  bool optimization_due() const;
  /// What there is to solve. `thorough` judges every loop and position anew instead of starting
  /// from the last judgement (for /optimize_map and the end of a drive).
  std::shared_ptr<const OptimizationProblem> problem(bool thorough = false) const;
  /// Takes the solution in and returns all poses with a new revision.
  KeyFramePoses apply(const OptimizationSolution& solution);

  KeyFramePoses poses() const;
  /// Odometry alone, laid so that the first key frame is where it is in poses().
  KeyFramePoses odometry() const;
  /// The correction between odometry and map: T_map_odom of the newest key frame.
  Pose T_map_odom() const;
  /// All loops with the graph's present opinion of them; those that no solution has judged yet
  /// count as believed.
  std::vector<std::pair<Loop, bool>> loops() const;
  /// The positions as the graph takes them: with the delay of their stamps in lever arm and
  /// covariance.
  std::vector<GnssPosition> positions() const;
  /// For each key frame the part of the map that it belongs to, from 0: what odometry, believed
  /// loops or a place in East-North-Up tie together. More than one part: how they lie to each other
  /// is unknown.
  std::vector<int> parts() const;
  /// The graph with its present poses, for files.
  pose_graph::PoseGraph graph() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Solves the graph; see doc/back_end.md. Never throws for what the data did: see the report.
std::shared_ptr<const OptimizationSolution> solve(const OptimizationProblem& problem);
const OptimizationReport& report_of(const OptimizationSolution& solution);

}  // namespace lidar_mapping::back_end
