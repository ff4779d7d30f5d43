// SPDX-License-Identifier: BSD-3-Clause
#include "judgement/match_judge.hpp"

#include "lidar_mapping/common/units.hpp"

#include "judgement/match_evidence.hpp"

namespace lidar_mapping::front_end {
namespace {

// Fractions of the usual quality. Chosen. Measured (doc/results/ablation.md): twice the first takes
// more than twice as long and gains little; its half, and half and twice the others, move nothing.
constexpr double kDoubtfulQuality = 0.75;
constexpr double kPoorQuality = 0.6;
constexpr double kLostQuality = 0.4;
/// Below this overlap a match has no meaning, whatever the usual value is. Chosen: a third of what
/// a match needs to be accepted in spite of a low quality (kMinUsualOverlap).
constexpr double kMinOverlap = 0.05;
/// Mean weight of the pairs. Chosen: at a wrong pose fewer than half of them fit. Measured
/// (doc/results/ablation.md): at twice of it errors are many times as large, at half the same.
constexpr double kMinPairQuality = 0.45;
/// If few points find a pair because the map does not cover the view yet, the pairs still fit
/// nearly as well as usual. Measured: those of a wrong pose have 0.65 to 0.88 of the usual quality.
constexpr double kUsualPairQualityFraction = 0.88;
/// Fraction of the points that has to find a pair then. Chosen: fewer may fit by chance.
constexpr double kMinUsualOverlap = 0.15;
// Distance from the prediction in standard deviations. Chosen far beyond a normal distribution,
// because motions jump; half and twice move nothing (doc/results/ablation.md).
constexpr double kDoubtfulInnovation = 6.0;
constexpr double kLostInnovation = 12.0;
/// Weight of the newest match in the running means. Chosen: a second at 10 Hz; half and twice move
/// nothing (doc/results/ablation.md).
constexpr double kLearningRate = 0.1;
/// Two turns a second. Chosen: faster than any vehicle or person turns while mapping.
constexpr double kMaxTurnRate = 4.0 * kPi;  // rad/s

}  // namespace

bool MatchJudge::has_usual_pair_quality(const NdtMatch& match) const {
  return match.overlap > kMinUsualOverlap &&
         pair_quality(match) > kUsualPairQualityFraction * mean_pair_quality_;
}

bool MatchJudge::is_below(double fraction, const NdtMatch& match) const {
  return match.quality < fraction * mean_quality_ && !has_usual_pair_quality(match);
}

bool MatchJudge::in_doubt(const NdtMatch& match, const MotionBelief& prediction) const {
  return !match.converged || match.quality < kDoubtfulQuality * mean_quality_ ||
         pair_quality(match) < kMinPairQuality ||
         innovation_of(match, prediction).sigmas() > kDoubtfulInnovation;
}

TrackingState MatchJudge::judge(const NdtMatch& match, const MotionBelief& prediction) const {
  if (match.overlap < kMinOverlap || is_below(kLostQuality, match) ||
      pair_quality(match) < kMinPairQuality || !is_finite(match.state.T_map_sensor) ||
      match.state.twist.head<3>().norm() > max_speed_ ||
      innovation_of(match, prediction).sigmas() > kLostInnovation) {
    return TrackingState::kLost;
  }
  return is_below(kPoorQuality, match) ? TrackingState::kDegraded : TrackingState::kTracking;
}

bool MatchJudge::is_possible_motion(const Pose& T_from_to, double seconds) const {
  return T_from_to.translation.norm() <= max_speed_ * seconds &&
         rotation_angle(T_from_to.rotation) <= kMaxTurnRate * seconds;
}

void MatchJudge::learn(const NdtMatch& match) {
  const bool is_poor = is_below(kPoorQuality, match);
  const auto update = [](double value, double& mean) {
    mean = mean == 0.0 ? value : mean + kLearningRate * (value - mean);
  };
  update(match.quality, mean_quality_);
  if (!is_poor) update(pair_quality(match), mean_pair_quality_);
}

}  // namespace lidar_mapping::front_end
