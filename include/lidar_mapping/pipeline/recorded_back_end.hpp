// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Result of an optimisation.
struct AppliedSolution {
  KeyFramePoses poses;  ///< T_map_base of all key frames.
  /// Verdicts on the loops that the graph now accepts or refuses other than the session says, or
  /// for another reason.
  std::vector<LoopVerdict> verdicts;
  /// Why the session does not have all of this yet; empty if it has what is due. The next solution
  /// or write_files() tries again.
  std::string storing_failure;
};

/// When the poses of a solution are stored in the session. All of them are written at once.
enum class PoseStorage {
  kAlways,  ///< with each solution
  /// when the drive is 20 key frames and a twentieth longer than at the last time, or when the map
  /// was turned to East-North-Up
  kWhenGrown
};

/// A back end that stores every input and result in a session: when an add_ function has returned,
/// its data survive the end of the process. A session that has content is resumed: its data are
/// inserted into the graph and optimised, so that poses, loops and indices are as before; this
/// solution is stored like any other (PoseStorage::kWhenGrown). Key frames,
/// measurements and loops are written first; if that throws FileError the graph is unchanged. One
/// thread calls it.
class RecordedBackEnd {
 public:
  /// Resumes `session` if it has key frames. Throws FileError.
  RecordedBackEnd(session::Session session, const back_end::BackEndConfig& config);

  /// Report of the solution with which the session was opened, with its computing time. Without
  /// key frames there was nothing to solve.
  const back_end::OptimizationReport& opening_report() const { return opening_report_; }

  /// Adds a key frame. Throws FileError, and InputError like BackEnd::add_key_frame().
  void add_key_frame(const KeyFrame& key_frame);
  /// Adds a loop. Returns false and changes nothing if an index is unknown or both indices are
  /// equal.
  bool add_loop(const Loop& loop);
  /// Whether this loop was added before. If matching finds a loop between the same two key frames
  /// again, it is not new; if a person gives another pose, it is a correction and therefore new.
  /// The cost is one look-up, however many loops there are.
  bool has_loop(const Loop& loop) const;
  /// Adds a position, transformed to the datum of the session. The graph uses those at the stamps
  /// of key frames.
  void add_gnss(const GnssPosition& position);
  /// Adds a sample in the axes of base_link. The graph uses those at the stamps of key frames.
  void add_imu(const ImuSample& sample_base);
  /// Adds a floor plane in base_link. The graph uses those at the stamps of key frames.
  void add_floor(const Floor& floor);

  /// Adds a verdict of loop closing. If the graph has the loop and thinks otherwise, the next
  /// solution says so again: the newest verdict in the session is that of the graph. What was said
  /// of the two key frames before in the same words, as by a search after a restart, is not stored
  /// again.
  void add_verdict(const LoopVerdict& verdict);

  /// Sets the datum of all positions that are added afterwards. If the session has another one, it
  /// keeps that, and the positions are transformed to it.
  void set_datum(const GeodeticDatum& datum);

  /// See BackEnd::optimization_due().
  bool optimization_due() const { return back_end_.optimization_due(); }
  /// See BackEnd::problem().
  std::shared_ptr<const back_end::OptimizationProblem> problem(bool thorough) const {
    return back_end_.problem(thorough);
  }
  /// Applies a solution whose computation took `seconds`, and stores its figures in the session,
  /// and its poses if they are due. If they cannot be stored the graph follows the solution all the
  /// same (AppliedSolution::storing_failure).
  AppliedSolution apply(const back_end::OptimizationSolution& solution, double seconds,
                        PoseStorage storage = PoseStorage::kAlways);

  /// Newest poses; their revision counts on over the whole session.
  KeyFramePoses poses() const;
  /// See BackEnd::odometry().
  KeyFramePoses odometry() const { return back_end_.odometry(); }
  /// See BackEnd::T_map_odom().
  Pose T_map_odom() const { return back_end_.T_map_odom(); }
  /// See BackEnd::graph().
  pose_graph::PoseGraph graph() const { return back_end_.graph(); }
  /// See BackEnd::in_enu().
  bool in_enu() const { return back_end_.in_enu(); }
  /// See BackEnd::parts().
  std::vector<int> parts() const { return back_end_.parts(); }
  /// Present verdict of the graph on every loop.
  std::vector<LoopVerdict> verdicts() const;

  /// Index below which loop closing has searched for good. Key frames with a match that still waits
  /// for others are searched again after a restart, because the match would be lost otherwise.
  KeyFrameIndex searched_key_frames() const;

  /// The session, for data that the graph does not need: scans, datum and configuration.
  session::Session& session() { return session_; }
  /// The session.
  const session::Session& session() const { return session_; }

  /// Updates trajectory/, the files about loops, doubt.csv and graph.g2o, and the poses of the
  /// session. Returns the sentences on the sections where the map is doubtful (warnings() in
  /// drive_doubt.hpp). Throws FileError.
  std::vector<std::string> write_files();

 private:
  void resume();
  void solve_at_opening();
  bool was_said(const LoopVerdict& verdict) const;
  void note_said(const LoopVerdict& verdict);
  std::vector<LoopVerdict> changed_verdicts();
  void store_solution(const KeyFramePoses& poses, PoseStorage storage);
  void store_verdicts();
  void store_poses(const KeyFramePoses& poses);

  session::Session session_;
  back_end::BackEnd back_end_;
  back_end::OptimizationReport opening_report_;
  Pose T_session_gnss_;  ///< Transformation of positions from their datum to that of the session.
  std::uint32_t first_revision_ = 0;
  std::size_t stored_poses_ = 0;  ///< Number of poses when the last ones were due.
  std::optional<session::RevisionRecord> unstored_;  ///< Revision whose poses are not stored yet.
  std::deque<LoopVerdict> unstored_verdicts_;        ///< Of the graph, not stored yet.
  bool uses_loops_ = true;                           ///< As configured.
  /// Newest verdict on each pair of key frames with a loop in the graph.
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict> last_verdicts_;
  /// What loop closing has said of each pair of key frames.
  std::set<std::tuple<KeyFrameIndex, KeyFrameIndex, Verdict, std::string>> said_;
  /// T_from_to of every loop in the graph; the newest one for each pair of key frames.
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, Pose> loop_poses_;
};

/// Inserts the key frames of a session with their measurements, and these loops, into a back end.
void replay(const session::Session& session, const std::vector<Loop>& loops,
            back_end::BackEnd& back_end);
/// The same with the loops of the session.
void replay(const session::Session& session, back_end::BackEnd& back_end);

/// Writes the files trajectory/, loops.csv, candidates.csv, loops.txt, doubt.csv and graph.g2o of a
/// session with these poses to `directory`. Returns what doubt.csv contains. Throws FileError.
DriveDoubt write_results(const session::Session& session, const back_end::BackEnd& back_end,
                         const KeyFramePoses& poses, const std::filesystem::path& directory);

}  // namespace lidar_mapping::pipeline
