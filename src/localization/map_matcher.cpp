// SPDX-License-Identifier: BSD-3-Clause
#include "map_matcher.hpp"

#include <algorithm>

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

/// m beyond the range of the points in which the map has to be in memory. Chosen: four times the
/// standard deviation with which a place is given up (localizer.cpp).
constexpr double kReach = 20.0;
/// The same for a match that goes further: it is repeated with more of the map. Chosen: what has
/// gone so far astray is a wrong pose, whatever else it finds there.
constexpr double kGreatestReach = 160.0;

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

NdtOptions coarse_match_options() {
  NdtOptions options;
  options.max_iterations = 10;
  options.translation_epsilon = 0.02;
  options.rotation_epsilon = 1e-3;
  return options;
}

NdtOptions fine_match_options() {
  NdtOptions options;
  options.max_iterations = kMaxIterations;
  return options;
}

/// Has the map around a pose in memory, as far as the points see and `reach` metres more.
void require_around(const Pose& T_map_base, const ScanPoints& points, double reach,
                    MapSurfaces& map) {
  const Eigen::Vector3f p_base_lidar = points.all.viewpoint().value_or(Eigen::Vector3f::Zero());
  map.require(T_map_base.translation, kMaxRange + p_base_lidar.norm() + reach);
}

bool is_uncertain(const PoseEstimate& predicted) {
  return predicted.covariance.diagonal().head<3>().maxCoeff() > kFineReach * kFineReach;
}

}  // namespace

MapMatch MapMatcher::match(const ScanPoints& points, MapSurfaces& map,
                           const PoseEstimate& predicted) {
  Alignment alignment;
  for (double reach = kReach; reach <= kGreatestReach; reach *= 2.0) {
    require_around(predicted.T_map_base, points, reach, map);
    alignment = aligned(points, map, predicted);
    if (alignment.excursion <= reach || map.is_whole()) break;
  }
  const NdtMatch& found = alignment.match;
  MapMatch match;
  match.converged = found.converged;
  match.estimate.T_map_base = found.state.T_map_sensor;
  match.estimate.covariance =
      found.information.topLeftCorner<6, 6>().ldlt().solve(Matrix6d::Identity());
  match.agreement = agreement_at(match.estimate.T_map_base, points, map);
  return match;
}

MapMatcher::Alignment MapMatcher::aligned(const ScanPoints& points, MapSurfaces& map,
                                          const PoseEstimate& predicted) {
  registration::MotionState start{predicted.T_map_base};
  double excursion = 0.0;
  if (is_uncertain(predicted)) {
    const NdtMatch coarse =
        matcher_.match(points.all, map.coarse(), belief_of(predicted, kCoarsePriorWeight), start,
                       coarse_match_options());
    start = coarse.state;
    excursion = coarse.excursion;
  }
  const NdtMatch found = matcher_.match(points.all, map.fine(), belief_of(predicted, 1.0), start,
                                        fine_match_options());
  return {found, excursion + found.excursion};
}

/// The points have no times, so they are one slice, with its filling behind them.
std::vector<MatchedPoint> MapMatcher::weighted(const ScanPoints& points, MapSurfaces& map,
                                               const Pose& T_map_base) {
  static_assert(registration::kNoPlane == kNotInMap);
  require_around(T_map_base, points, kReach, map);
  const registration::NdtPoints& all = points.all;
  const std::vector<float> weights = matcher_.weights(
      all, map.fine(), registration::MotionState{T_map_base}, fine_match_options());
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
