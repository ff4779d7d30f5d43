// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// What came of an optimisation.
struct AppliedSolution {
  KeyFramePoses poses;
  /// Of the loops of which the graph thinks otherwise than before.
  std::vector<LoopVerdict> verdicts;
};

/// A back end whose every input and result is kept in a session: what an add_ function returned
/// from survives the process. A session that has content already is gone on with: its data are put
/// into the graph again and solved, so that poses, loops and indices are there as before. Key
/// frames and measurements are written first; where that throws FileError the graph is as it was.
/// One thread calls it.
class RecordedBackEnd {
 public:
  RecordedBackEnd(session::Session session, const back_end::BackEndConfig& config);

  void add_key_frame(const KeyFrame& key_frame);
  /// False (and nothing is changed) if an index is unknown or both are the same.
  bool add_loop(const Loop& loop);
  /// Whether add_loop() has taken this one before: matching that finds the same two key frames
  /// again finds nothing new, whereas a person who gives another pose corrects the loop. Costs a
  /// look-up, however many loops there are.
  bool has_loop(const Loop& loop) const;
  void add_gnss(const GnssPosition& position);
  void add_imu(const ImuSample& sample_base);
  void add_floor(const Floor& floor);

  /// Datum of the positions that come from now on. A session that has another one keeps it, and the
  /// positions are turned to it.
  void set_datum(const GeodeticDatum& datum);

  bool optimization_due() const { return back_end_.optimization_due(); }
  std::shared_ptr<const back_end::OptimizationProblem> problem(bool thorough) const {
    return back_end_.problem(thorough);
  }
  /// The poses are kept in the session only if wanted: a caller that solves often need not write
  /// them all each time.
  AppliedSolution apply(const back_end::OptimizationSolution& solution, double seconds,
                        bool keep_poses = true);

  /// Revisions count on over the whole session.
  KeyFramePoses poses() const;
  /// See BackEnd::odometry().
  KeyFramePoses odometry() const { return back_end_.odometry(); }
  Pose T_map_odom() const { return back_end_.T_map_odom(); }
  /// See BackEnd::graph().
  pose_graph::PoseGraph graph() const { return back_end_.graph(); }
  /// See BackEnd::parts().
  std::vector<int> parts() const { return back_end_.parts(); }
  /// The graph's present opinion of every loop.
  std::vector<LoopVerdict> verdicts() const;

  /// For what the graph does not need: verdicts of loop closing, scans, datum, configuration.
  session::Session& session() { return session_; }
  const session::Session& session() const { return session_; }

  /// Where the map as it is now is doubtful (drive_doubt.hpp), as sentences; empty: nowhere.
  std::vector<std::string> warnings() const;

  /// Brings trajectory/, the files about loops and graph.g2o up to date. Throws FileError.
  void write_files() const;

 private:
  void resume();

  session::Session session_;
  back_end::BackEnd back_end_;
  Pose T_session_gnss_;  ///< from the frame of the positions to that of the session's datum
  std::uint32_t first_revision_ = 0;
  std::vector<Verdict> opinions_;  ///< of the graph, loop by loop
  /// T_from_to of every loop in the graph, the newest of those between the same two.
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, Pose> loop_poses_;
};

/// Puts key frames and their measurements of a session, and these loops, into a back end.
void replay(const session::Session& session, const std::vector<Loop>& loops,
            back_end::BackEnd& back_end);
/// The same with the session's own loops.
void replay(const session::Session& session, back_end::BackEnd& back_end);

/// Writes trajectory/, loops.csv, candidates.csv, loops.txt, doubt.csv and graph.g2o of a session,
/// with these poses, to `directory`.
void write_results(const session::Session& session, const back_end::BackEnd& back_end,
                   const KeyFramePoses& poses, const std::filesystem::path& directory);

}  // namespace lidar_mapping::pipeline
