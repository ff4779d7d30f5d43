// SPDX-License-Identifier: BSD-3-Clause
#include "candidates/candidate_generator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "candidates/starting_pose.hpp"
#include "matching/submap_builder.hpp"
#include "sight.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Chosen: more than are registered, so that each source is heard.
constexpr std::size_t kMaxPerSource = 10;
// m of path length between candidates of one pass; chosen: less than the reach of a match
// (kMaxShift of the view, 15 m).
constexpr double kMinSpacing = 8.0;
// m; a loop with a smaller error is satisfied by the map. Chosen: false loops err by far more.
constexpr double kSatisfiedError = 1.0;
// m; a fix may have this error and still give its candidates: the largest errors by reflections in
// streets. Chosen.
constexpr double kMaxGnssError = 30.0;
// m of path length from a candidate to the key frames that may replace it. Chosen: more than the
// reach of a view (kMaxShift, 15 m) and the spacing of candidates together (kMinSpacing, 8 m).
constexpr double kMaxShiftAlongPass = 25.0;
constexpr double kMaxStartError = 3.0;  // m; expected error of a starting pose; chosen

Eigen::Vector2d horizontal(const Pose& pose) { return pose.translation.head<2>(); }

bool is_satisfied(const Loop& loop, const TrajectoryNode& from, const TrajectoryNode& to) {
  if (!from.optimised || !to.optimised) return false;
  const Vector6d error = difference(loop.T_from_to, from.T_map_base.inverse() * to.T_map_base);
  return error.head<3>().norm() < kSatisfiedError;
}

}  // namespace

CandidateGenerator::CandidateGenerator(const LoopClosingConfig& config,
                                       const std::filesystem::path& directory)
    : config_(config), appearances_(directory) {}

void CandidateGenerator::append(const KeyFrame& key_frame,
                                const std::optional<Appearance>& appearance) {
  const NodeId node = trajectory_.append(key_frame);
  const bool continues = node > 0 && trajectory_[node - 1].segment == trajectory_[node].segment;
  const double step = continues ? trajectory_[node].travelled - trajectory_[node - 1].travelled
                                : std::numeric_limits<double>::infinity();
  graph_distance_.append(step);
  if (appearance) sight_ = range_of_sight(appearance->view);
  update_grids(node);
  appearances_.append(appearance);  // last, because it throws if the disk is full
}

void CandidateGenerator::update_grids(NodeId node) {
  map_grid_.set_position(node, horizontal(trajectory_[node].T_map_base));
  if (const auto& gnss = trajectory_[node].gnss) {
    gnss_grid_.set_position(node, gnss->p_enu_antenna.head<2>());
  }
}

void CandidateGenerator::update_poses(const KeyFramePoses& poses) {
  for (const NodeId node : trajectory_.update(poses)) update_grids(node);
  update_loops();
}

void CandidateGenerator::add_gnss(const GnssPosition& position) {
  if (const auto node = trajectory_.add_gnss(position)) update_grids(*node);
}

void CandidateGenerator::add_loop(const Loop& loop) { loops_.push_back(loop); }

/// Only loops that the newest estimate satisfies reduce its uncertainty: the back end may not have
/// solved since, or may not use a loop.
void CandidateGenerator::update_loops() {
  std::vector<GraphDistance::LoopEdge> links;
  for (const Loop& loop : loops_) {
    const auto from = trajectory_.find(loop.from);
    const auto to = trajectory_.find(loop.to);
    if (!from || !to) continue;
    if (is_satisfied(loop, trajectory_[*from], trajectory_[*to])) links.emplace_back(*from, *to);
  }
  graph_distance_.update_loops(links);
}

/// Neighbouring key frames always observe the same location, and scan and submap must not share
/// clouds.
bool CandidateGenerator::is_far_along_path(NodeId older) const {
  const NodeId newest = trajectory_.size() - 1;
  if (!std::isfinite(graph_distance_.to(older))) return true;
  const auto gap = static_cast<int>(trajectory_[newest].index - trajectory_[older].index);
  const double path_length = trajectory_[newest].travelled - trajectory_[older].travelled;
  return gap >= std::max(config_.diff_num, config_.extend_frame_num + kQueryKeyFrames) &&
         path_length >= least_path_length(sight_, config_);
}

bool CandidateGenerator::is_admissible(NodeId older) const {
  return trajectory_[older].index < end_of_candidates_ && is_far_along_path(older) &&
         may_overlap(prior_to(older), config_);
}

Prior CandidateGenerator::prior_to(NodeId older) const {
  return prior_between(trajectory_, graph_distance_, older, trajectory_.size() - 1, config_);
}

/// Non-maximum suppression: the nearest nodes first, at most one per kMinSpacing of one pass.
std::vector<CandidateGenerator::NodeId> CandidateGenerator::suppress_neighbours(
    std::vector<NodeId> nodes, const Eigen::Vector2d& centre, const PositionGrid& grid) const {
  std::stable_sort(nodes.begin(), nodes.end(), [&](NodeId a, NodeId b) {
    return (grid.position(a) - centre).squaredNorm() < (grid.position(b) - centre).squaredNorm();
  });
  std::vector<NodeId> chosen;
  for (const NodeId node : nodes) {
    const auto is_near = [&](NodeId other) {
      return trajectory_.path_length_between(node, other) < kMinSpacing;
    };
    if (std::any_of(chosen.begin(), chosen.end(), is_near)) continue;
    chosen.push_back(node);
    if (chosen.size() == kMaxPerSource) break;
  }
  return chosen;
}

std::vector<CandidateGenerator::NodeId> CandidateGenerator::admissible_within(
    const PositionGrid& grid, double radius, const std::function<bool(NodeId)>& qualifies) const {
  const NodeId newest = trajectory_.size() - 1;
  if (!grid.has(newest)) return {};
  std::vector<NodeId> nodes;
  for (const NodeId node : grid.within(grid.position(newest), radius)) {
    if (node != newest && qualifies(node) && is_admissible(node)) nodes.push_back(node);
  }
  return suppress_neighbours(std::move(nodes), grid.position(newest), grid);
}

std::vector<CandidateGenerator::NodeId> CandidateGenerator::by_position() const {
  if (!config_.position_candidates) return {};
  const double radius = largest_radius(trajectory_[trajectory_.size() - 1].travelled, config_);
  return admissible_within(map_grid_, radius,
                           [this](NodeId node) { return std::isfinite(graph_distance_.to(node)); });
}

std::vector<CandidateGenerator::NodeId> CandidateGenerator::by_gnss() const {
  if (!config_.gnss_candidates) return {};
  const double radius = config_.detect_area + kMaxGnssError;
  return admissible_within(gnss_grid_, radius,
                           [this](NodeId node) { return gnss_is_more_certain(prior_to(node)); });
}

std::vector<CandidateGenerator::NodeId> CandidateGenerator::by_appearance() const {
  if (!config_.appearance_candidates) return {};
  return appearances_.similar_to_newest([this](NodeId node) { return is_admissible(node); });
}

/// Replaces the candidate by the key frame of the same pass that is nearest to the starting pose:
/// the nearer it is, the more the scans overlap.
void CandidateGenerator::move_to_nearest_key_frame(Candidate& candidate) const {
  const Pose T_odom_newest = trajectory_[candidate.node].T_odom_base * candidate.T_from_to;
  const auto distance = [&](NodeId node) {
    return (trajectory_[node].T_odom_base.translation - T_odom_newest.translation).norm();
  };
  const auto is_on_same_pass = [&](NodeId node) {
    return trajectory_.path_length_between(node, candidate.node) < kMaxShiftAlongPass &&
           is_admissible(node);
  };
  NodeId best = candidate.node;
  for (NodeId node = candidate.node; node-- > 0 && is_on_same_pass(node);) {
    if (distance(node) < distance(best)) best = node;
  }
  for (NodeId node = candidate.node + 1; node < trajectory_.size() && is_on_same_pass(node);
       ++node) {
    if (distance(node) < distance(best)) best = node;
  }
  candidate.node = best;
  candidate.prior = prior_to(best);
  candidate.T_from_to = trajectory_[best].T_odom_base.inverse() * T_odom_newest;
}

/// Candidates from all sources. A key frame that several sources give belongs to the first of them.
std::vector<Candidate> CandidateGenerator::unscored_candidates() const {
  std::vector<Candidate> result;
  const auto collect = [&](LoopSource source, const std::vector<NodeId>& nodes) {
    for (const NodeId node : nodes) {
      const auto is_known = [&](const Candidate& c) { return c.node == node; };
      if (std::any_of(result.begin(), result.end(), is_known)) continue;
      result.push_back({node, source, prior_to(node), {}, 0.0});
    }
  };
  collect(LoopSource::kPosition, by_position());
  collect(LoopSource::kGnss, by_gnss());
  collect(LoopSource::kAppearance, by_appearance());
  return result;
}

std::vector<Candidate> CandidateGenerator::candidates() const {
  if (trajectory_.size() < 2) return {};
  const auto appearance = appearances_[trajectory_.size() - 1];
  const auto cells = appearance ? appearance->view.cells() : std::vector<Eigen::Vector2f>();
  std::vector<Candidate> result;
  for (Candidate& candidate : unscored_candidates()) {
    const StartingPose start =
        starting_pose_by_views(candidate.prior, appearances_[candidate.node], appearance, cells);
    candidate.T_from_to = start.T_from_to;
    candidate.score = start.score;
    move_to_nearest_key_frame(candidate);
    const double distance = candidate.T_from_to.translation.norm();
    if (distance <= loop_distance_limit(sight_, config_) + kMaxStartError)
      result.push_back(candidate);
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return result;
}

}  // namespace lidar_mapping::loop_closing
