// SPDX-License-Identifier: BSD-3-Clause
#include "condensed/condensed_minimizer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lidar_mapping::pose_graph {

namespace {

// Fraction of the cost by which it may seem to rise at the minimum, as in gauss_newton.cpp. Chosen:
// far above the rounding of sums of doubles, far below the tolerance at which the search ends.
constexpr double kCostRounding = 1e-9;
// Part of the tolerance below which the next gain has to be expected, if its step is not taken.
// Chosen: the steps of the flat solver take one with a gain below the tolerance, too.
constexpr double kNextGain = 1e-3;
// Damping after the first undamped step that fails. Chosen: the default of Ceres, whose first trust
// region has a radius of 1e4.
constexpr double kFirstDamping = 1e-4;
// Damping beyond which no step is tried. Chosen: its steps are too short to change a pose.
constexpr double kLargestDamping = 1e32;

/// Damping of the steps, by how well the last ones were predicted (Nocedal & Wright 2006), with the
/// factors of Ceres. It is the inverse of the radius of a trust region.
class Damping {
 public:
  explicit Damping(const std::optional<double>& radius) : value_(radius ? 1.0 / *radius : 0.0) {}

  double value() const { return value_; }
  /// After a step that took `quality` times the expected decrease.
  void decrease(double quality) {
    const double cubed = 2.0 * quality - 1.0;
    value_ *= std::max(1.0 / 3.0, 1.0 - cubed * cubed * cubed);
    growth_ = 2.0;
  }
  /// After a step that did not lower the cost. Returns false if there is no larger damping.
  bool increase() {
    value_ = value_ > 0.0 ? value_ * growth_ : kFirstDamping;
    growth_ *= 2.0;
    return value_ < kLargestDamping;
  }

 private:
  double value_;
  double growth_ = 2.0;
};

/// The steps of one problem, and when they end.
template <int size>
class CondensedMinimizer {
 public:
  CondensedMinimizer(CondensedProblem<size>& problem, CondensedStructure structure,
                     const MinimizerSettings& settings, int threads)
      : problem_(problem),
        settings_(settings),
        system_(problem, std::move(structure), threads),
        damping_(settings.initial_radius),
        cost_(total_cost<size>(problem, threads)),
        threads_(threads) {}

  MinimizerSummary run() {
    MinimizerSummary summary;
    summary.initial_cost = cost_;
    while (message_.empty() && summary.iterations < settings_.max_iterations) {
      ++summary.iterations;
      take_step();
    }
    summary.final_cost = cost_;
    // Without a solution of the equations nothing is known; otherwise this is the least cost found.
    summary.usable = std::isfinite(cost_) && (has_moved_ || message_ != kSingular);
    summary.message = message_.empty() ? "the iterations ran out" : message_;
    return summary;
  }

 private:
  static constexpr const char* kConverged = "converged";
  static constexpr const char* kSingular = "the equations are singular";

  void take_step() {
    const CondensedStep step = system_.solve(damping_.value());
    if (!step.is_usable) return increase_damping(kSingular);
    problem_.apply(system_.nodes(), step.step);
    const double gain = cost_ - total_cost<size>(problem_, threads_);
    if (gain >= 0.0) return accept(gain, step.expected_gain);
    problem_.restore();
    // At the minimum rounding decides whether the cost falls.
    if (gain > -kCostRounding * cost_ && step.expected_gain < kCostRounding * cost_) {
      message_ = kConverged;
      return;
    }
    increase_damping("a step did not lower the cost");
  }

  void accept(double gain, double expected) {
    has_moved_ = true;
    cost_ -= gain;
    damping_.decrease(expected > 0.0 ? gain / expected : 1.0);
    // Near the minimum the next gain is to this one at most as this one is to the last one.
    const double rate = last_gain_ > 0.0 ? std::min(1.0, gain / last_gain_) : 1.0;
    last_gain_ = gain;
    const bool small = expected < settings_.tolerance * cost_;
    const bool next_is_small = gain * rate < kNextGain * settings_.tolerance * cost_;
    if (small || next_is_small) message_ = kConverged;
  }

  void increase_damping(const char* reason) {
    if (!damping_.increase()) message_ = reason;
  }

  CondensedProblem<size>& problem_;
  const MinimizerSettings& settings_;
  CondensedSystem<size> system_;
  Damping damping_;
  double cost_;
  int threads_;
  double last_gain_ = 0.0;
  bool has_moved_ = false;
  std::string message_;  ///< why the steps ended; empty before that
};

}  // namespace

template <int size>
MinimizerSummary minimize_condensed(CondensedProblem<size>& problem, CondensedStructure structure,
                                    const MinimizerSettings& settings, int threads) {
  return CondensedMinimizer<size>(problem, std::move(structure), settings, threads).run();
}

template MinimizerSummary minimize_condensed<3>(CondensedProblem<3>&, CondensedStructure,
                                                const MinimizerSettings&, int);
template MinimizerSummary minimize_condensed<6>(CondensedProblem<6>&, CondensedStructure,
                                                const MinimizerSettings&, int);

}  // namespace lidar_mapping::pose_graph
