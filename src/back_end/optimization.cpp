#include "lidar_mapping/back_end/optimization.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/back_end/gnss_alignment.hpp"
#include "lidar_mapping/back_end/robust_solver.hpp"

namespace lidar_mapping::back_end {

namespace {

// Poses are then within a fraction of a millimetre of the minimum.
constexpr double kTolerance = 1e-5;

DriveNode& node_at(DriveGraph& drive, int position) {
  return drive.nodes[static_cast<std::size_t>(position)];
}

/// Moves the nodes of some segments rigidly.
void move_segments(DriveGraph& drive, const std::vector<bool>& segments, const Pose& T_new_old) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (!segments[static_cast<std::size_t>(drive.segment_of(static_cast<int>(i)))]) continue;
    drive.nodes[i].T_map_base = T_new_old * drive.nodes[i].T_map_base;
  }
  if (segments.front()) drive.T_map_first = T_new_old * drive.T_map_first;
}

std::vector<bool> members(const std::vector<int>& connected, int group) {
  std::vector<bool> result;
  for (const int g : connected) result.push_back(g == group);
  return result;
}

/// Where a loop that is new says that the group of its newer end lies, relative to where it is.
Pose correction_by(DriveGraph& drive, const DriveLoop& loop, bool move_to) {
  const Pose& from = node_at(drive, loop.from).T_map_base;
  const Pose& to = node_at(drive, loop.to).T_map_base;
  const Pose correction = from * loop.loop.T_from_to * to.inverse();
  return move_to ? correction : correction.inverse();
}

/// Puts segments that a new loop ties to an older one beside it, where the solver can begin. Of
/// several loops the one counts with which the most others agree.
void join_segments(DriveGraph& drive) {
  constexpr double kAgreement_m = 2.0;
  std::vector<int> connected = connected_segments(drive, false);
  const std::vector<int> joined = connected_segments(drive, true);
  for (int group = static_cast<int>(connected.size()) - 1; group > 0; --group) {
    const auto slot = static_cast<std::size_t>(group);
    if (connected[slot] != group || joined[slot] == group) continue;
    const std::vector<bool> segments = members(connected, group);
    std::vector<Pose> corrections;
    for (const DriveLoop& loop : drive.loops) {
      if (loop.weighed) continue;
      const bool from = segments[static_cast<std::size_t>(drive.segment_of(loop.from))];
      const bool to = segments[static_cast<std::size_t>(drive.segment_of(loop.to))];
      if (from != to) corrections.push_back(correction_by(drive, loop, to));
    }
    const Eigen::Vector3d anywhere =
        node_at(drive, drive.segment_starts[slot]).T_map_base.translation;
    int most = -1;
    const Pose* best = nullptr;
    for (const Pose& a : corrections) {
      const int votes = static_cast<int>(std::count_if(
          corrections.begin(), corrections.end(),
          [&](const Pose& b) { return (a * anywhere - b * anywhere).norm() < kAgreement_m; }));
      if (votes <= most) continue;
      most = votes;
      best = &a;
    }
    if (best != nullptr) move_segments(drive, segments, *best);
  }
}

std::vector<AlignmentSample> alignment_samples(const DriveGraph& drive,
                                               const std::vector<bool>& segments,
                                               const BackEndConfig& config) {
  std::vector<AlignmentSample> samples;
  for (const DriveGnss& gnss : drive.gnss) {
    if (!segments[static_cast<std::size_t>(drive.segment_of(gnss.node))]) continue;
    const GnssPosition& p = gnss.position;
    AlignmentSample sample;
    sample.p_enu = p.p_enu_antenna;
    if (!has_altitude(p)) sample.p_enu.z() = std::numeric_limits<double>::quiet_NaN();
    sample.p_map = drive.nodes[static_cast<std::size_t>(gnss.node)].T_map_base * p.p_base_antenna;
    sample.stddev_horizontal = horizontal_stddev(p, config);
    sample.stddev_altitude = altitude_stddev(p, config);
    samples.push_back(sample);
  }
  return samples;
}

AlignmentLimits alignment_limits(const BackEndConfig& config) {
  return {config.gnss_alignment_distance, config.gnss_alignment_stddev_deg * M_PI / 180.0};
}

/// Over the whole track, or where that has drifted too far to fit, over its beginning.
std::optional<Alignment> align_track(const std::vector<AlignmentSample>& samples,
                                     const Eigen::Quaterniond& R_level_map,
                                     const BackEndConfig& config) {
  const AlignmentLimits limits = alignment_limits(config);
  auto alignment = align_to_enu(samples, R_level_map, limits);
  for (std::size_t count = 16; !alignment && count < samples.size(); count *= 2) {
    const std::vector<AlignmentSample> beginning(samples.begin(),
                                                 samples.begin() + static_cast<long>(count));
    alignment = align_to_enu(beginning, R_level_map, limits);
  }
  return alignment;
}

/// Turns groups of segments to East-North-Up as soon as their tracks allow, or again if `again`.
/// True if one was turned that was not before.
bool georeference(DriveGraph& drive, const BackEndConfig& config, bool again,
                  OptimizationReport& report) {
  if (!config.use_gnss || drive.gnss.empty()) return false;
  bool turned = false;
  const std::vector<int> connected = connected_segments(drive, true);
  for (int group = 0; group < static_cast<int>(connected.size()); ++group) {
    const std::vector<bool> segments = members(connected, group);
    bool already = false;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      already = already || (segments[s] && drive.in_enu[s]);
    }
    if (already && !again) continue;
    const auto alignment = align_track(alignment_samples(drive, segments, config),
                                       levelling(drive, segments, config), config);
    if (!alignment) continue;
    move_segments(drive, segments, alignment->T_enu_map);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (segments[s]) drive.in_enu[s] = true;
    }
    turned = turned || !already;
    report.gnss_rms = alignment->rms_horizontal;
  }
  return turned;
}

/// The states as odometry alone has them, from the first node of each segment.
void follow_odometry(const DriveGraph& drive, FactorGraph& graph) {
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    if (!drive.nodes[i].joined) continue;
    const Pose motion = drive.nodes[i - 1].T_odom_base.inverse() * drive.nodes[i].T_odom_base;
    graph.set_pose(static_cast<int>(i), graph.pose(static_cast<int>(i) - 1) * motion);
  }
}

/// Moves stretches of the states onto the positions about them: drift over the whole track would
/// make every far position look false.
void pull_to_gnss(const DriveGraph& drive, const BackEndConfig& config, FactorGraph& graph) {
  constexpr std::size_t kStretch = 100;
  DriveGraph moved = drive;
  for (std::size_t i = 0; i < moved.nodes.size(); ++i) {
    moved.nodes[i].T_map_base = graph.pose(static_cast<int>(i));
  }
  const std::vector<bool> everywhere(drive.in_enu.size(), true);
  const std::vector<AlignmentSample> samples = alignment_samples(moved, everywhere, config);
  Pose correction;
  std::size_t node = 0;
  for (std::size_t begin = 0; begin < samples.size(); begin += kStretch / 2) {
    const std::size_t end = std::min(begin + kStretch, samples.size());
    const auto alignment = align_to_enu(
        {samples.begin() + static_cast<long>(begin), samples.begin() + static_cast<long>(end)},
        Eigen::Quaterniond::Identity(), alignment_limits(config));
    if (alignment) correction = alignment->T_enu_map;
    const std::size_t middle = std::min(begin + 3 * kStretch / 4, samples.size() - 1);
    const std::size_t until = end == samples.size()
                                  ? moved.nodes.size()
                                  : static_cast<std::size_t>(drive.gnss[middle].node);
    for (; node < until; ++node) {
      if (!drive.in_enu[static_cast<std::size_t>(drive.segment_of(static_cast<int>(node)))])
        continue;
      graph.set_pose(static_cast<int>(node), correction * moved.nodes[node].T_map_base);
    }
  }
}

/// From the present poses, with everything that was believed and everything new. True if nothing
/// contradicts the outcome.
bool solve_from_present(DriveFactors& factors, RobustSolution& solution) {
  solution = solve_as_marked(factors.graph, factors.marked, {50, 1e10, kTolerance});
  if (!solution.success) return false;
  const std::vector<bool> agreed = believed(factors.graph);
  for (std::size_t i = 0; i < agreed.size(); ++i) {
    if (factors.marked[i] != agreed[i]) return false;
  }
  return true;
}

RobustSolution solve_factors(const DriveGraph& drive, const BackEndConfig& config,
                             DriveFactors& factors, bool thorough) {
  const std::vector<StateBlock> present = factors.graph.states;
  RobustSolution solution;
  if (thorough) factors.marked.assign(factors.marked.size(), true);
  if (solve_from_present(factors, solution)) return solution;
  factors.graph.states = present;
  follow_odometry(drive, factors.graph);
  if (config.use_gnss && !config.georeference_only) pull_to_gnss(drive, config, factors.graph);
  solution = solve_graduated(factors.graph);
  if (!solution.success) factors.graph.states = present;
  return solution;
}

bool used(const RobustSolution& solution, int constraint) {
  return constraint >= 0 && solution.used[static_cast<std::size_t>(constraint)];
}

void take_over(const DriveFactors& factors, const RobustSolution& solution, DriveGraph& drive) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    drive.nodes[i].T_map_base = factors.graph.pose(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    drive.loops[i].used = used(solution, factors.loop_of[i]);
    drive.loops[i].weighed = factors.loop_of[i] >= 0;
  }
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    drive.gnss[i].horizontal_used = used(solution, factors.horizontal_of[i]);
    drive.gnss[i].altitude_used = used(solution, factors.altitude_of[i]);
    drive.gnss[i].weighed = factors.horizontal_of[i] >= 0;
  }
}

/// Judgements on the whole drive: those so far, but for the part that was solved, and the new ones.
void fill(const OptimizationProblem& problem, const DriveGraph& solved,
          const RobustSolution& solution, OptimizationReport& report) {
  const Judgements before = count_judgements(problem.drive);
  const Judgements after = count_judgements(solved);
  report.success = solution.success;
  report.key_frames = problem.key_frames;
  report.cost_before = solution.cost_before;
  report.cost_after = solution.cost_after;
  report.iterations = solution.iterations;
  report.loops_used = problem.judged.loops_used - before.loops_used + after.loops_used;
  report.loops_refused = problem.judged.loops_refused - before.loops_refused + after.loops_refused;
  report.gnss_used = problem.judged.gnss_used - before.gnss_used + after.gnss_used;
  report.gnss_refused = problem.judged.gnss_refused - before.gnss_refused + after.gnss_refused;
  report.message = solution.success
                       ? "optimised " + std::to_string(solved.nodes.size()) + " key frames in " +
                             std::to_string(solution.iterations) + " iterations"
                       : "the solver failed, poses are as before: " + solution.message;
}

}  // namespace

namespace {

/// Only what is new and its surroundings; where that does not settle everything nothing moves.
void solve_window(const OptimizationProblem& problem, OptimizationSolution& result) {
  DriveFactors factors = make_factors(result.drive, problem.config);
  RobustSolution solution;
  result.whole_needed = !solve_from_present(factors, solution);
  solution.success = solution.success && !result.whole_needed;
  if (solution.success) take_over(factors, solution, result.drive);
  fill(problem, result.drive, solution, result.report);
}

}  // namespace

std::shared_ptr<const OptimizationSolution> solve(const OptimizationProblem& problem) {
  auto result = std::make_shared<OptimizationSolution>();
  DriveGraph& drive = result->drive;
  drive = problem.drive;
  result->window = problem.window;
  result->key_frames = problem.key_frames;
  if (drive.nodes.empty()) {
    result->report.message = "there are no key frames yet; nothing to optimise";
    return result;
  }
  if (problem.window) {
    solve_window(problem, *result);
    return result;
  }
  if (problem.config.use_loop_close) join_segments(drive);
  const bool turned = georeference(drive, problem.config, false, result->report);
  DriveFactors factors = make_factors(drive, problem.config);
  const RobustSolution solution =
      solve_factors(drive, problem.config, factors, problem.thorough || turned);
  if (solution.success) take_over(factors, solution, drive);
  if (problem.config.georeference_only) {
    georeference(drive, problem.config, true, result->report);
  }
  fill(problem, drive, solution, result->report);
  return result;
}

const OptimizationReport& report_of(const OptimizationSolution& solution) {
  return solution.report;
}

}  // namespace lidar_mapping::back_end
