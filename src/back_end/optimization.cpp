// SPDX-License-Identifier: BSD-3-Clause
#include "optimization.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include "lidar_mapping/pose_graph/least_eigenvalue.hpp"
#include "lidar_mapping/pose_graph/robust_solver.hpp"

#include "drive/drive_placement.hpp"
#include "factors/drive_factors.hpp"
#include "gnss/gnss_delay.hpp"
#include "weights/drift_fraction.hpp"
#include "weights/systematic_errors.hpp"

namespace lidar_mapping::back_end {

namespace {

// Relative change of the cost at which the search ends. Chosen: the poses are then within a
// fraction of a millimetre of the minimum.
constexpr double kCostTolerance = 1e-5;
// Below this eigenvalue, some motion of the map by metres hardly changes the cost. Chosen: it has a
// standard deviation of 10 km, while weak priors (1 km) have an eigenvalue of 1e-6.
constexpr double kWeaklyConstrained = 1e-8;

/// Sets the states to odometry alone, from the first node of each segment.
void chain_odometry(const DriveGraph& drive, pose_graph::FactorGraph& graph) {
  for (std::size_t i = 1; i < drive.nodes.size(); ++i) {
    if (!drive.nodes[i].connected) continue;
    const Pose motion = drive.nodes[i - 1].T_odom_base.inverse() * drive.nodes[i].T_odom_base;
    graph.set_pose(static_cast<int>(i), graph.pose(static_cast<int>(i) - 1) * motion);
  }
}

/// Solves from the current poses with all constraints that were used and all new ones. True if no
/// constraint contradicts the result.
bool solve_from_current(DriveFactors& factors, pose_graph::RobustSolution& solution) {
  solution = pose_graph::solve_selected(factors.graph, factors.selected,
                                        {50, std::nullopt, kCostTolerance, {}});
  return solution.success && pose_graph::consistent_constraints(factors.graph) == factors.selected;
}

pose_graph::RobustSolution solve_factors(const DriveGraph& drive, const BackEndConfig& config,
                                         DriveFactors& factors, bool thorough) {
  const std::vector<pose_graph::StateBlock> current = factors.graph.states;
  pose_graph::RobustSolution solution;
  if (thorough) factors.selected.assign(factors.selected.size(), true);
  if (solve_from_current(factors, solution)) return solution;
  factors.graph.states = current;
  chain_odometry(drive, factors.graph);
  if (config.use_gnss && !config.georeference_only) shift_to_gnss(drive, config, factors.graph);
  solution = pose_graph::solve_graduated(factors.graph);
  if (!solution.success) factors.graph.states = current;
  return solution;
}

void store_solution(const DriveFactors& factors, const pose_graph::RobustSolution& solution,
                    DriveGraph& drive) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    drive.nodes[i].T_map_base = factors.graph.pose(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < drive.loops.size(); ++i) {
    drive.loops[i].used = is_used(factors.loop_of[i], solution.used);
    drive.loops[i].evaluated = true;  // one without a factor is not to be used
  }
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    drive.gnss[i].horizontal_used = is_used(factors.horizontal_of[i], solution.used);
    drive.gnss[i].altitude_used = is_used(factors.altitude_of[i], solution.used);
    drive.gnss[i].evaluated = factors.horizontal_of[i] >= 0;
  }
}

/// Frees the old factors first: two graphs at once would need most memory on a long drive.
void rebuild_factors(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  factors = {};
  factors = make_factors(drive, config);
}

bool corrects_delays(const DriveGraph& drive) {
  return std::any_of(drive.gnss_delays.begin(), drive.gnss_delays.end(),
                     [](const GnssDelay& delay) { return delay.is_corrected(); });
}

void correct_delays(const SystematicErrors& systematic, DriveGraph& drive) {
  for (GnssDelay& delay : drive.gnss_delays) {
    if (!delay.is_corrected()) continue;
    delay.seconds += systematic.delay;
    delay.arm_error += systematic.lever_arm;
  }
}

/// Estimates the errors of odometry and the delay of GNSS from a solution with the uncorrected
/// odometry and its full drift. The factors are rebuilt with them.
void estimate_errors(const BackEndConfig& config, const pose_graph::RobustSolution& solution,
                     DriveFactors& factors, DriveGraph& drive) {
  const double scatter = position_scatter(factors, solution.used);
  const SystematicErrors systematic =
      estimate_systematic_errors(drive, factors, solution.used, scatter);
  drive.odometry_errors.scale_error = systematic.scale_error;
  correct_delays(systematic, drive);
  drive.odometry_errors.drift_fraction =
      observed_drift_fraction(drive, config, factors, solution.used);
  rebuild_factors(drive, config, factors);
  if (!corrects_delays(drive)) return;
  // With a smaller drift the delay is determined by whole streets instead of single bends. In
  // single bends the errors of odometry are similar and look like a delay.
  const SystematicErrors remaining =
      estimate_systematic_errors(drive, factors, solution.used, scatter);
  correct_delays(remaining, drive);
  rebuild_factors(drive, config, factors);
}

/// Solves again with the estimated errors of odometry. If that fails, everything stays as it is.
void solve_with_estimated_errors(const BackEndConfig& config, DriveFactors& factors,
                                 pose_graph::RobustSolution& solution, DriveGraph& drive) {
  const std::vector<GnssDelay> delays = drive.gnss_delays;
  estimate_errors(config, solution, factors, drive);
  pose_graph::RobustSolution refined = solve_factors(drive, config, factors, false);
  if (!refined.success) {
    drive.gnss_delays = delays;
    drive.odometry_errors = {};
    rebuild_factors(drive, config, factors);
    return;
  }
  refined.cost_before = solution.cost_before;
  refined.iterations += solution.iterations;
  solution = std::move(refined);
  store_solution(factors, solution, drive);
}

bool uses_any(const std::vector<int>& constraints, const pose_graph::RobustSolution& solution) {
  return std::any_of(constraints.begin(), constraints.end(),
                     [&](int constraint) { return is_used(constraint, solution.used); });
}

/// Counts for the whole drive: those so far, without the solved part, plus the new ones.
void fill_report(const OptimizationProblem& problem, const DriveGraph& solved,
                 const pose_graph::RobustSolution& solution, OptimizationReport& report) {
  const UsageCounts before = count_usage(problem.drive);
  const UsageCounts after = count_usage(solved);
  report.success = solution.success;
  report.key_frames = problem.key_frames;
  report.cost_before = solution.cost_before;
  report.cost_after = solution.cost_after;
  report.iterations = solution.iterations;
  report.loops_used = problem.usage.loops_used - before.loops_used + after.loops_used;
  report.loops_refused = problem.usage.loops_refused - before.loops_refused + after.loops_refused;
  report.gnss_used = problem.usage.gnss_used - before.gnss_used + after.gnss_used;
  report.gnss_refused = problem.usage.gnss_refused - before.gnss_refused + after.gnss_refused;
  report.message = solution.success
                       ? "optimised " + std::to_string(solved.nodes.size()) + " key frames in " +
                             std::to_string(solution.iterations) + " iterations"
                       : "the solver failed and no pose has changed: " + solution.message;
}

/// Solves only the new constraints and their surroundings. If that is not sufficient, no pose
/// changes.
void solve_window(const OptimizationProblem& problem, OptimizationSolution& result) {
  DriveFactors factors = make_factors(result.drive, problem.config);
  pose_graph::RobustSolution solution;
  result.full_solve_needed = !solve_from_current(factors, solution);
  solution.success = solution.success && !result.full_solve_needed;
  if (solution.success) store_solution(factors, solution, result.drive);
  fill_report(problem, result.drive, solution, result.report);
}

/// Positions that only place the map are no constraints; the inliers of the alignment count as
/// used.
void report_placement(const DriveGraph& drive, const Georeference& alignment,
                      OptimizationReport& report) {
  report.gnss_rms = alignment.rms_horizontal;
  report.gnss_used = alignment.inliers;
  report.gnss_refused = drive.unusable_gnss + drive.gnss.size() - alignment.inliers;
  std::ostringstream text;
  text.precision(3);
  if (alignment.inliers > 0) {
    text << "placed in East-North-Up as a whole, without a change of its shape, "
         << alignment.rms_horizontal << " m rms from " << alignment.inliers << " positions";
  } else {
    text << "not placed in East-North-Up, because the positions do not determine its heading";
  }
  report.message += "; " + text.str();
  report.remarks.push_back("the map is " + text.str());
}

/// Reports how well the least constrained motion is determined, so that a map with too few
/// constraints is noticed.
void report_least_eigenvalue(const DriveFactors& factors,
                             const pose_graph::RobustSolution& solution,
                             OptimizationReport& report) {
  report.least_eigenvalue = pose_graph::least_eigenvalue(factors.graph, solution.used);
  std::ostringstream text;
  text.precision(3);
  text << "; smallest eigenvalue of the information matrix " << report.least_eigenvalue;
  report.message += text.str();
  if (report.least_eigenvalue >= kWeaklyConstrained) return;
  const std::string warning = "the constraints hardly determine the map";
  report.message += ": " + warning;
  report.remarks.push_back(warning + ", so parts of it may be wrong by metres");
}

/// Finds the poses of the whole drive from all constraints, then again with the errors of odometry
/// that they show. `factors` become those of the solution.
pose_graph::RobustSolution solve_drive(const OptimizationProblem& problem, bool thorough,
                                       DriveFactors& factors, DriveGraph& drive) {
  pose_graph::RobustSolution solution = solve_factors(drive, problem.config, factors, thorough);
  if (!solution.success) return solution;
  store_solution(factors, solution, drive);
  if (uses_any(factors.horizontal_of, solution)) {
    solve_with_estimated_errors(problem.config, factors, solution, drive);
  }
  return solution;
}

/// Places the segments of the drive and the whole of it, and solves all constraints.
void solve_whole(const OptimizationProblem& problem, OptimizationSolution& result) {
  DriveGraph& drive = result.drive;
  if (problem.config.use_loop_close) connect_segments(drive);
  const Georeference alignment = georeference(drive, problem.config, false);
  if (problem.config.use_gnss) estimate_gnss_delays(drive, problem.config);
  drive.odometry_errors = {};
  DriveFactors factors = make_factors(drive, problem.config);
  const pose_graph::RobustSolution solution =
      solve_drive(problem, problem.thorough || alignment.newly_aligned, factors, drive);
  if (!solution.success) {
    drive = problem.drive;  // no segment stays where it was placed for this solution
    return fill_report(problem, drive, solution, result.report);
  }
  result.report.gnss_rms = alignment.rms_horizontal;
  std::optional<Georeference> placement;
  if (problem.config.georeference_only) placement = georeference(drive, problem.config, true);
  fill_report(problem, drive, solution, result.report);
  if (placement) report_placement(drive, *placement, result.report);
  if (problem.thorough) report_least_eigenvalue(factors, solution, result.report);
}

}  // namespace

std::shared_ptr<const OptimizationSolution> solve(const OptimizationProblem& problem) {
  auto result = std::make_shared<OptimizationSolution>();
  result->drive = problem.drive;
  result->window = problem.window;
  result->key_frames = problem.key_frames;
  if (result->drive.nodes.empty()) {
    result->report.message = "there are no key frames yet; nothing to optimise";
  } else if (problem.window) {
    solve_window(problem, *result);
  } else {
    solve_whole(problem, *result);
  }
  return result;
}

const OptimizationReport& report_of(const OptimizationSolution& solution) {
  return solution.report;
}

}  // namespace lidar_mapping::back_end
