// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/match_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace lidar_mapping::front_end {
namespace {

using registration::kNdtParts;
using registration::kNdtSectors;

/// Ways to divide the scan into two halves; each function tells whether a part belongs to the first
/// half. Left and right, ahead and behind, every other sector, near and far.
using Halving = bool (*)(std::size_t part);
constexpr std::array<Halving, 4> kHalvings = {
    [](std::size_t part) { return part % kNdtSectors < kNdtSectors / 2; },
    [](std::size_t part) { return (part + 2) % kNdtSectors < kNdtSectors / 2; },
    [](std::size_t part) { return part % 2 == 0; },
    [](std::size_t part) { return part < kNdtSectors; }};

/// Weight of a residual, so that a part of a scan counts as it did in the match.
const double kDataWeight = NdtOptions{}.data_weight;

/// The pose that the points of the selected parts prefer, as a step from the match, and its
/// covariance.
template <typename IsSelected>
UncertainStep half_of(const std::vector<NdtPart>& parts, const IsSelected& is_selected,
                      const Matrix6d& prior) {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (!is_selected(part)) continue;
    hessian += parts[part].hessian;
    gradient += parts[part].gradient;
  }
  UncertainStep half;
  half.covariance = (kDataWeight * hessian + prior).inverse();
  half.step = -kDataWeight * (half.covariance * gradient);
  return half;
}

void compare(const UncertainStep& a, const UncertainStep& b, StepEvidence& evidence) {
  const UncertainStep d{a.step - b.step, a.covariance + b.covariance};
  const auto keep_largest = [](double value, double& largest) {
    largest = std::max(largest, value);
  };
  keep_largest(d.step.head<3>().norm(), evidence.disagreement);
  keep_largest(d.step.tail<3>().norm(), evidence.disagreement_angle);
  keep_largest(d.sigmas(), evidence.disagreement_sigmas);
}

/// The effective number of sectors: this number of equal sectors would have the same distribution
/// of weights.
double effective_sectors(const std::vector<NdtPart>& parts) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t sector = 0; sector < kNdtSectors; ++sector) {
    const double trace = parts[sector].hessian.topLeftCorner<3, 3>().trace() +
                         parts[sector + kNdtSectors].hessian.topLeftCorner<3, 3>().trace();
    sum += trace;
    squares += trace * trace;
  }
  return squares > 0.0 ? sum * sum / squares : 0.0;
}

}  // namespace

double pair_quality(const NdtMatch& match) {
  return match.overlap > 0.0 ? match.quality / match.overlap : 0.0;
}

double UncertainStep::sigmas() const { return std::sqrt(step.dot(covariance.ldlt().solve(step))); }

UncertainStep innovation_of(const NdtMatch& match, const MotionBelief& prediction) {
  return {difference(prediction.state.T_map_sensor, match.state.T_map_sensor),
          prediction.information.inverse().topLeftCorner<6, 6>()};
}

StepEvidence evidence_of(const NdtMatch& match, const MotionBelief& prediction) {
  StepEvidence evidence;
  evidence.overlap = match.overlap;
  evidence.pair_quality = pair_quality(match);
  evidence.residual_variance = match.residual_variance;
  evidence.converged = match.converged ? 1.0 : 0.0;
  evidence.iterations = match.iterations;
  const UncertainStep innovation = innovation_of(match, prediction);
  evidence.surprise = innovation.step.head<3>().norm();
  evidence.surprise_angle = innovation.step.tail<3>().norm();
  evidence.surprise_sigmas = innovation.sigmas();
  if (match.parts.size() != kNdtParts) return evidence;
  const Matrix6d prior = innovation.covariance.inverse();
  for (const Halving in_first : kHalvings) {
    const auto in_second = [&](std::size_t part) { return !in_first(part); };
    compare(half_of(match.parts, in_first, prior), half_of(match.parts, in_second, prior),
            evidence);
  }
  evidence.sectors = effective_sectors(match.parts);
  return evidence;
}

}  // namespace lidar_mapping::front_end
