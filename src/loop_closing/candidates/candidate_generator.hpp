// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "candidates/position_grid.hpp"
#include "candidates/prior.hpp"

namespace lidar_mapping::loop_closing {

/// An older key frame that may observe the same location as the newest one.
struct Candidate {
  Trajectory::NodeId node = 0;
  LoopSource source = LoopSource::kPosition;
  Prior prior;
  Pose T_from_to;      ///< starting pose of the registration
  double score = 0.0;  ///< best ViewMatch::score of the two bird's-eye views
};

/// Holds the poses and appearances of all key frames of a drive, without clouds, and finds older
/// key frames that may observe the same location as the newest one (doc/loop_closing.md).
class CandidateGenerator {
 public:
  /// Appearances are stored in a temporary file in `directory`.
  explicit CandidateGenerator(
      const LoopClosingConfig& config,
      const std::filesystem::path& directory = std::filesystem::temp_directory_path());

  /// Appends the next key frame; without an appearance if its cloud is not available.
  void append(const KeyFrame& key_frame, const std::optional<Appearance>& appearance);
  void update_poses(const KeyFramePoses& poses);
  void add_gnss(const GnssPosition& position);
  /// Adds a loop. It reduces the uncertainty between key frames as soon as the map satisfies it.
  void add_loop(const Loop& loop);

  /// Only key frames below this index are candidates from now on.
  void search_only_before(KeyFrameIndex end) { end_of_candidates_ = end; }

  const Trajectory& trajectory() const { return trajectory_; }
  /// Range of sight of the newest key frame that has a cloud, m; without limit if there is none.
  double sight() const { return sight_; }
  /// Candidates for the newest key frame with their starting poses, best first.
  std::vector<Candidate> candidates() const;

 private:
  using NodeId = Trajectory::NodeId;

  bool is_far_along_path(NodeId older) const;
  bool is_admissible(NodeId older) const;
  Prior prior_to(NodeId older) const;
  void update_grids(NodeId node);
  void update_loops();
  std::vector<NodeId> admissible_within(const PositionGrid& grid, double radius,
                                        const std::function<bool(NodeId)>& qualifies) const;
  std::vector<NodeId> suppress_neighbours(std::vector<NodeId> nodes, const Eigen::Vector2d& centre,
                                          const PositionGrid& grid) const;
  std::vector<NodeId> by_position() const;
  std::vector<NodeId> by_gnss() const;
  std::vector<NodeId> by_appearance() const;
  std::vector<Candidate> unscored_candidates() const;
  void move_to_nearest_key_frame(Candidate& candidate) const;

  LoopClosingConfig config_;
  Trajectory trajectory_;
  GraphDistance graph_distance_;
  AppearanceIndex appearances_;
  PositionGrid map_grid_;
  PositionGrid gnss_grid_;
  std::vector<Loop> loops_;
  double sight_ = std::numeric_limits<double>::infinity();
  KeyFrameIndex end_of_candidates_ = std::numeric_limits<KeyFrameIndex>::max();
};

}  // namespace lidar_mapping::loop_closing
