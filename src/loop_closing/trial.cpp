#include "trial.hpp"

#include <algorithm>

namespace lidar_mapping::loop_closing {

namespace {

const TrajectoryNode& newest(const Trajectory& trajectory) {
  return trajectory[trajectory.size() - 1];
}

bool is_accepted(const Trial& trial) { return trial.judgement.verdict == Verdict::kAccepted; }

/// The Hessian knows of noise alone; a loop is never stiffer than what it is measured against.
Covariance6 floored(const Covariance6& covariance, const LoopClosingConfig& config) {
  return covariance + diagonal_covariance(config.min_stddev_x, config.min_stddev_q);
}

}  // namespace

bool settles(const Trial& trial) {
  return is_accepted(trial) && is_beyond_doubt(trial.match, trial.candidate.prior);
}

void keep_best(std::vector<Trial>& trials, const Trajectory& trajectory) {
  const auto is_worse = [](const Trial& a, const Trial& b) {
    if (is_accepted(a) != is_accepted(b)) return is_accepted(b);
    return a.margin() < b.margin();
  };
  const auto best = std::max_element(trials.begin(), trials.end(), is_worse);
  for (Trial& trial : trials) {
    if (!is_accepted(trial) || &trial == &*best) continue;
    const KeyFrameIndex better = trajectory[best->candidate.node].index;
    trial.judgement = {
        Verdict::kRefused,
        figure_sentence("overlap minus twice the free-space violation", trial.margin(), "below",
                        best->margin(), "of the match with key frame " + std::to_string(better))};
  }
}

Loop to_loop(const Trial& trial, const Trajectory& trajectory, const LoopClosingConfig& config) {
  Loop loop;
  loop.from = trajectory[trial.candidate.node].index;
  loop.to = newest(trajectory).index;
  loop.stamp = newest(trajectory).stamp;
  loop.T_from_to = trial.match.alignment.T_target_source;
  loop.covariance = floored(trial.match.alignment.covariance, config);
  loop.fitness = trial.match.figures.fitness;
  loop.overlap = trial.match.figures.overlap;
  loop.source = trial.candidate.source;
  return loop;
}

LoopVerdict to_verdict(const Trial& trial, const Trajectory& trajectory) {
  LoopVerdict verdict;
  verdict.from = trajectory[trial.candidate.node].index;
  verdict.to = newest(trajectory).index;
  verdict.stamp = newest(trajectory).stamp;
  verdict.source = trial.candidate.source;
  verdict.verdict = trial.judgement.verdict;
  verdict.reason = trial.judgement.reason;
  verdict.distance = trial.candidate.prior.T_from_to.translation.norm();
  verdict.fitness = trial.match.figures.fitness;
  verdict.overlap = trial.match.figures.overlap;
  verdict.free_space_violation = trial.match.figures.free_space_violation;
  verdict.horizontal_eigenvalue = trial.match.figures.horizontal_eigenvalue;
  verdict.innovation =
      innovation_of(trial.candidate.prior, trial.match.alignment.T_target_source).whole;
  return verdict;
}

LoopVerdict confirmed_verdict(const Loop& loop, const Loop& by) {
  LoopVerdict verdict;
  verdict.from = loop.from;
  verdict.to = loop.to;
  verdict.stamp = loop.stamp;
  verdict.source = loop.source;
  verdict.verdict = Verdict::kAccepted;
  verdict.reason = "the match of key frames " + std::to_string(by.from) + " and " +
                   std::to_string(by.to) + " confirms it (unanchored_stretch)";
  verdict.fitness = loop.fitness;
  verdict.overlap = loop.overlap;
  return verdict;
}

}  // namespace lidar_mapping::loop_closing
