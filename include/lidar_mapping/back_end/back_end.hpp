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
#include "lidar_mapping/common/usage_counts.hpp"
#include "lidar_mapping/pose_graph/pose_graph.hpp"

namespace lidar_mapping::back_end {

/// The result of an optimisation in figures; the answer of /optimize_map.
struct OptimizationReport : UsageCounts {
  bool success = false;        ///< false if the solver failed; the poses are then unchanged
  std::string message;         ///< summary for the user, or why the optimisation failed
  std::size_t key_frames = 0;  ///< number of key frames in the whole graph
  double cost_before = 0.0;    ///< chi2 of the used constraints at the start poses, without unit
  double cost_after = 0.0;     ///< chi2 of the used constraints at the solution, without unit
  int iterations = 0;          ///< solver steps, summed over all rounds
  double gnss_rms = 0.0;       ///< horizontal RMS error of the last alignment to East-North-Up, m
  /// Smallest eigenvalue of the information matrix after a thorough solution
  /// (least_eigenvalue.hpp): it shows how well the least constrained motion of the map is
  /// determined. 0 if it was not computed, or if a motion is not constrained at all.
  double least_eigenvalue = 0.0;
  double seconds = 0.0;  ///< computing time, set by the caller of solve(): the core has no clock
  /// Warnings that the user has to know besides the figures, without a full stop at the end.
  std::vector<std::string> remarks;
};

/// All inputs of solve() as a value, so that a worker thread can solve it while new sensor data
/// arrive.
struct OptimizationProblem;
/// The result of solve().
struct OptimizationSolution;

/// Builds the pose graph of a drive and holds its poses. The constraints come from odometry, loops,
/// GNSS, IMU and floor; each kind can be switched off. The graph is solved outside of this object:
///
///   auto solution = solve(*back_end.problem());   // takes long, runs in a worker thread
///   KeyFramePoses poses = back_end.apply(*solution);
///
/// Data that arrive between the two calls are kept, and their poses follow the correction. The
/// class may be called from one thread at a time.
class BackEnd {
 public:
  /// An empty graph; `config` is copied.
  explicit BackEnd(const BackEndConfig& config);
  ~BackEnd();

  /// Adds a node. Its pose follows by odometry from the newest optimised pose. Throws InputError
  /// unless the indices increase and the pose is finite.
  void add_key_frame(const KeyFrame& key_frame);
  /// Adds a loop. Returns false and changes nothing if it does not fit.
  bool add_loop(const Loop& loop);
  /// Whether a loop can be added: false if an index is unknown, if both indices are the same, or if
  /// the pose or its covariance has no meaning.
  bool fits(const Loop& loop) const;
  /// Adds a position whose stamp is that of a key frame; it may come before the key frame. The
  /// newest 1000 positions without a key frame are stored, older ones are dropped. A key frame
  /// that has a position already keeps it.
  void add_gnss(const GnssPosition& position);
  /// Adds an IMU sample in the axes of base_link; stamps are treated as in add_gnss().
  void add_imu(const ImuSample& sample_base);
  /// Adds the floor below the vehicle in base_link; stamps are treated as in add_gnss().
  void add_floor(const Floor& floor);

  /// True if one of the optimize_step parameters of the configuration is reached.
  bool optimization_due() const;
  /// A copy of the data to solve. With `thorough` each loop and each position is evaluated again;
  /// otherwise the solver starts from the last decisions. Used for /optimize_map and at the end of
  /// a drive.
  std::shared_ptr<const OptimizationProblem> problem(bool thorough = false) const;
  /// Applies a solution to the graph and returns all poses with a new revision.
  KeyFramePoses apply(const OptimizationSolution& solution);

  /// The newest poses T_map_base of all key frames with their revision.
  KeyFramePoses poses() const;
  /// Poses from odometry alone, placed so that the first key frame has the same pose as in poses().
  KeyFramePoses odometry() const;
  /// The correction from odometry to the map, T_map_odom at the newest key frame.
  Pose T_map_odom() const;
  /// All loops, each with true if the graph uses it. A loop that no solution has evaluated yet
  /// counts as used, unless a person or use_loop_close leaves it out.
  std::vector<std::pair<Loop, bool>> loops() const;
  /// The positions as the graph uses them: the delay of their stamps is included in lever arm and
  /// covariance.
  std::vector<GnssPosition> positions() const;
  /// The connected part of the map, from 0, for each key frame: key frames of one part are
  /// connected by odometry, by used loops, or by positions in East-North-Up. The relative pose of
  /// two parts is unknown.
  std::vector<int> parts() const;
  /// Whether most key frames lie in East-North-Up. Where only some of them do, the others are in
  /// parts() whose relative pose is unknown in any case.
  bool in_enu() const;
  /// The graph with its newest poses and the used relative poses, for export to a file.
  pose_graph::PoseGraph graph() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Solves the graph; the method is described in doc/back_end.md. The function does not throw for
/// any content of the data: failures are reported.
std::shared_ptr<const OptimizationSolution> solve(const OptimizationProblem& problem);
/// The report of a solution; valid as long as the solution.
const OptimizationReport& report_of(const OptimizationSolution& solution);

}  // namespace lidar_mapping::back_end
