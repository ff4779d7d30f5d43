// SPDX-License-Identifier: BSD-3-Clause
#include "map_matcher.hpp"

#include <Eigen/Cholesky>

namespace lidar_mapping::localization {

namespace {

using registration::MotionBelief;
using registration::NdtMatch;
using registration::NdtOptions;

/// m: standard deviation of a prediction from which on the coarse voxels are matched first. Chosen:
/// three of them are half of a fine voxel and more.
constexpr double kFineReach = 0.25;
/// Information of the twist, 1 / (m/s)^2: the scan is deskewed, so its twist is zero and stays so.
/// Chosen: far above what points can contribute.
constexpr double kNoTwist = 1e12;
/// Weight of the prediction in the coarse match, as in sweep_matcher.cpp.
constexpr double kCoarsePriorWeight = 0.01;
/// Iterations of a fine match. Chosen: matches that converge do so in 5 to 12.
constexpr int kMaxIterations = 20;

/// Points above the ground from which on these alone are judged. Chosen: a tree has as many; with
/// fewer, in a field, the ground has to do.
constexpr std::size_t kLeastStructure = 50;

MotionBelief belief_of(const PoseEstimate& predicted, double weight) {
  MotionBelief belief;
  belief.state.T_map_sensor = predicted.T_map_base;
  belief.information.topLeftCorner<6, 6>() =
      weight * predicted.covariance.ldlt().solve(Matrix6d::Identity());
  belief.information.bottomRightCorner<6, 6>() = kNoTwist * Matrix6d::Identity();
  return belief;
}

NdtOptions coarse_options() {
  NdtOptions options;
  options.max_iterations = 10;
  options.translation_epsilon = 0.02;
  options.rotation_epsilon = 1e-3;
  return options;
}

NdtOptions fine_options() {
  NdtOptions options;
  options.max_iterations = kMaxIterations;
  return options;
}

bool is_uncertain(const PoseEstimate& predicted) {
  return predicted.covariance.diagonal().head<3>().maxCoeff() > kFineReach * kFineReach;
}

}  // namespace

MapMatch MapMatcher::match(const ScanPoints& points, MapSurfaces& map,
                           const PoseEstimate& predicted) {
  map.set_center(predicted.T_map_base.translation);
  registration::MotionState start{predicted.T_map_base};
  if (is_uncertain(predicted)) {
    start = matcher_
                .match(points.all, map.coarse(), belief_of(predicted, kCoarsePriorWeight), start,
                       coarse_options())
                .state;
  }
  const NdtMatch found =
      matcher_.match(points.all, map.fine(), belief_of(predicted, 1.0), start, fine_options());
  MapMatch match;
  match.converged = found.converged;
  match.estimate.T_map_base = found.state.T_map_sensor;
  match.estimate.covariance =
      found.information.topLeftCorner<6, 6>().ldlt().solve(Matrix6d::Identity());
  match.agreement = agreement_at(match.estimate.T_map_base, points, map);
  return match;
}

/// The points have no times, so they are one slice, with its filling behind them.
std::vector<MatchedPoint> MapMatcher::weighted(const ScanPoints& points, MapSurfaces& map,
                                               const Pose& T_map_base) {
  static_assert(registration::kNoPlane == kNotInMap);
  map.set_center(T_map_base.translation);
  const registration::NdtPoints& all = points.all;
  const std::vector<float> weights =
      matcher_.weights(all, map.fine(), registration::MotionState{T_map_base}, fine_options());
  std::vector<MatchedPoint> result(all.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = {Eigen::Vector3f(all.x()[i], all.y()[i], all.z()[i]), weights[i]};
  }
  return result;
}

Agreement MapMatcher::agreement_at(const Pose& T_map_base, const ScanPoints& points,
                                   MapSurfaces& map) {
  const registration::MotionState state{T_map_base};
  const bool has_structure = points.structure.size() >= kLeastStructure;
  const registration::NdtPoints& judged = has_structure ? points.structure : points.near;
  Agreement result;
  result.coverage = matcher_.evaluate(points.near, map.fine(), state, {}).overlap;
  result.agreement = matcher_.evaluate(judged, map.fine(), state, {}).quality;
  result.points = points.near.size();
  return result;
}

}  // namespace lidar_mapping::localization
