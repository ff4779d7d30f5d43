// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/step_belief.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

// Cost of a wrong step that is called correct, in units of a correct step that is called doubtful.
// A person inspects whole sections: one more step in a doubtful section costs less than a new
// section. Chosen: doubt begins below a safety of 0.6 and ends at 0.9.
constexpr double kCostOfMissedDoubt = 1.5;
constexpr double kCostOfMissedDoubtInDoubt = 9.0;

constexpr std::size_t kFeatures = 22;  // by definition: the numbers that features() returns
using Features = std::array<double, kFeatures>;

/// Coefficients of a feature.
struct Weights {
  double probability;
  double error;        ///< log10 of it, m
  double error_angle;  ///< log10 of it, rad
  double safety;
};
using Model = std::array<Weights, kFeatures>;

// Written by scripts/fit_step_belief.py.
#include "judgement/step_belief_coefficients.inc"

double logarithm(double value, double least) { return std::log10(std::max(value, least)); }

/// The same as features() in fit_step_belief.py.
Features features(const StepEvidence& e) {
  return {1.0,
          logarithm(e.sigma, 1e-4),
          logarithm(e.sigma_angle, 1e-5),
          logarithm(e.surprise, 1e-3),
          logarithm(e.surprise_angle, 1e-4),
          logarithm(e.surprise_sigmas, 1e-2),
          logarithm(e.disagreement, 1e-3),
          logarithm(e.disagreement_angle, 1e-4),
          logarithm(e.disagreement_sigmas, 1e-2),
          e.overlap,
          e.pair_quality,
          logarithm(e.points, 1.0),
          e.rescued,
          e.degenerate,
          logarithm(e.residual_variance, 1e-2),
          e.sectors,
          logarithm(e.motion_change, 1e-3),
          logarithm(e.motion_change_angle, 1e-4),
          e.converged,
          logarithm(e.sweep_gap, 1e-3),
          logarithm(e.sweep_gap_angle, 1e-4),
          logarithm(e.turn, 1e-3)};
}

double weighted(const Features& x, const Model& model, double Weights::*coefficient) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += x[i] * model[i].*coefficient;
  return sum;
}

double logistic(const Features& x, const Model& model, double Weights::*coefficient) {
  return 1.0 / (1.0 + std::exp(-weighted(x, model, coefficient)));
}

}  // namespace

bool StepBelief::is_safe(bool in_doubt) const {
  return (1.0 - safety) * (in_doubt ? kCostOfMissedDoubtInDoubt : kCostOfMissedDoubt) <= safety;
}

StepBelief evaluate_step(const StepEvidence& evidence, EvidenceSource source) {
  const bool is_ndt = source == EvidenceSource::kNdt;
  const Model& model = is_ndt ? kNdtModel : kSlidingWindowModel;
  const Features x = features(evidence);
  StepBelief belief;
  belief.probability = logistic(x, model, &Weights::probability);
  belief.expected_error = std::pow(10.0, weighted(x, model, &Weights::error));
  belief.expected_error_angle = std::pow(10.0, weighted(x, model, &Weights::error_angle));
  belief.safety = logistic(x, model, &Weights::safety);
  return belief;
}

void DoubtState::apply(const StepBelief& belief, FrontEndStatus& status) {
  if (status.state == TrackingState::kLost) {
    status.probability = 0.0;
    return;
  }
  status.probability = belief.probability;
  status.expected_error = belief.expected_error;
  status.expected_error_angle = belief.expected_error_angle;
  // The unobserved directions are already reported, and the scans of a tunnel have to be inserted
  // into the map.
  if (!status.degenerate_directions.empty()) return;
  in_doubt_ = !belief.is_safe(in_doubt_);
  if (status.state == TrackingState::kTracking && in_doubt_) {
    status.state = TrackingState::kDoubtful;
  }
}

}  // namespace lidar_mapping::front_end
