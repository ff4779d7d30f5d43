#include "lidar_mapping/front_end/step_belief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace lidar_mapping::front_end {
namespace {

/// Below this probability of being right a step claims nothing and is not built on.
constexpr double kUsable = 0.3;
/// Below this probability of being off by less than what counts as wrong a step is doubtful.
constexpr double kSafe = 0.9;

constexpr std::size_t kFeatures = 19;
using Coefficients = std::array<double, kFeatures>;

struct Model {
  Coefficients probability;
  Coefficients safety;
};

// Written by scripts/fit_step_belief.py.
#include "step_belief_coefficients.inc"

double logarithm(double value, double least) { return std::log10(std::max(value, least)); }

/// As features() of fit_step_belief.py.
Coefficients features(const StepEvidence& e) {
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
          logarithm(e.unsteadiness, 1e-3),
          logarithm(e.unsteadiness_angle, 1e-4),
          e.converged};
}

double logistic(const Coefficients& coefficients, const Coefficients& x) {
  return 1.0 / (1.0 + std::exp(-std::inner_product(x.begin(), x.end(), coefficients.begin(), 0.0)));
}

}  // namespace

bool StepBelief::is_safe() const { return safety >= kSafe && reach <= 1.0; }

StepBelief believe(const StepEvidence& evidence, EvidenceSource source) {
  const Coefficients x = features(evidence);
  // Covariances of other methods say too little of their errors to go by, or there are none.
  if (source == EvidenceSource::kSlidingWindow) {
    return {logistic(kSlidingWindowModel.probability, x), logistic(kSlidingWindowModel.safety, x),
            0.0, true};
  }
  const double probability = logistic(kNdtModel.probability, x);
  const double reach =
      std::max(evidence.sigma / kWrongStep, evidence.sigma_angle / kWrongStepAngle);
  return {probability, logistic(kNdtModel.safety, x), 3.0 * reach, probability >= kUsable};
}

void lower(const StepBelief& belief, FrontEndStatus& status) {
  if (status.state == TrackingState::kLost) {
    status.probability = 0.0;
    return;
  }
  status.probability = belief.probability;
  // What is not known is said already, and a tunnel has to come into the map.
  if (!status.degenerate_directions.empty()) return;
  if (!belief.is_usable) status.state = TrackingState::kDegraded;
  if (status.state == TrackingState::kTracking && !belief.is_safe()) {
    status.state = TrackingState::kDoubtful;
  }
}

}  // namespace lidar_mapping::front_end
