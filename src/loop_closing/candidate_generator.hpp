// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "position_grid.hpp"
#include "prior.hpp"

namespace lidar_mapping::loop_closing {

/// An older key frame that may see what the newest one sees.
struct Candidate {
  Trajectory::NodeId node = 0;
  LoopSource source = LoopSource::kPosition;
  Prior prior;
  Pose T_from_to;      ///< where to start the registration
  double score = 0.0;  ///< how well the two views from above agree there, 0 to 1
};

/// The memory of a drive, without its clouds: where key frames are and how they look. Answers which
/// of them the newest one may see again (doc/loop_closing.md).
class CandidateGenerator {
 public:
  /// Appearances are kept in a file in that folder.
  explicit CandidateGenerator(
      const LoopClosingConfig& config,
      const std::filesystem::path& directory = std::filesystem::temp_directory_path());

  /// Takes in the next key frame; without an appearance if its cloud is not to be had.
  void append(const KeyFrame& key_frame, const std::optional<Appearance>& appearance);
  void update_poses(const KeyFramePoses& poses);
  void add_gnss(const GnssPosition& position);
  /// A loop that may shorten the way between key frames once the map follows it.
  void add_loop(const Loop& loop);

  const Trajectory& trajectory() const { return trajectory_; }
  /// Candidates for the newest key frame with their starting poses, the most promising first.
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
};

}  // namespace lidar_mapping::loop_closing
