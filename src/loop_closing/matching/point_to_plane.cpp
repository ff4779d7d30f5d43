// SPDX-License-Identifier: BSD-3-Clause
#include "matching/point_to_plane.hpp"

#include <algorithm>
#include <array>
#include <map>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/robust_weights.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "matching/correspondence_cache.hpp"

namespace lidar_mapping::loop_closing {

namespace {

/// A stage of the alignment.
struct Level {
  float pair_distance;  ///< m, from a point to its partner at most
  std::size_t points;   ///< of the source
  int iterations;       ///< at most
};
/// From coarse to fine. Chosen: the first reaches farther than a starting pose is off, each of the
/// others half as far as the one before; the last has the most points, for its precision.
constexpr std::array<Level, 4> kLevels = {
    {{5.0F, 1000, 15}, {2.5F, 1000, 12}, {1.2F, 2000, 10}, {0.6F, 3000, 10}}};

// m; a level ends after a step below these. Chosen: a quarter of kMinSigma.
constexpr double kStepTranslation = 5e-3;
constexpr double kStepRotation = 5e-4;  // rad; at 10 m as much as kStepTranslation
constexpr int kMinPairs = 30;           // five for each of six unknowns; chosen
constexpr double kMinSigma = 0.02;      // m, of a point; chosen: the range noise of a LiDAR

// m; points in one cell of this size belong to one surface. Chosen: walls between two windows and
// the sides of cars are about as large.
constexpr double kSurfaceSize = 2.0;

/// Normal equations of one iteration.
struct Equations {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0.0;
  double weight = 0.0;
  int pairs = 0;
};

/// A point of the source with its partner in the target.
struct Residual {
  double value = 0.0;   // m, along the normal
  double weight = 0.0;  // 0 to 1
  Vector6d jacobian;    // with respect to perturbed(T, d)
  Eigen::Vector3d p_target;
};

/// Calls `use` with the residual of every point of a level that has a partner on a plane.
template <typename Use>
void for_each_residual(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                       CorrespondenceCache& pairs, const Pose& T, const Level& level,
                       const Use& use) {
  const Eigen::Matrix3d R = T.rotation_matrix();
  const std::size_t stride = std::max<std::size_t>(1, source.size() / level.points);
  for (std::size_t i = 0; i < source.size(); i += stride) {
    const Eigen::Vector3d p_source = source[i].cast<double>();
    Residual residual;
    residual.p_target = R * p_source + T.translation;
    const auto pair = pairs.nearest(i, residual.p_target.cast<float>(), level.pair_distance);
    if (!pair) continue;
    const Eigen::Vector3d normal = target.normal(pair->index).cast<double>();
    if (normal.isZero()) continue;
    residual.value =
        normal.dot(residual.p_target - target.tree().points()[pair->index].cast<double>());
    const Eigen::Vector3d normal_source = R.transpose() * normal;
    residual.jacobian << normal_source, p_source.cross(normal_source);
    const double scale = 0.5 * level.pair_distance;
    residual.weight =
        geman_mcclure_weight_of_squares(residual.value * residual.value, scale * scale);
    use(residual);
  }
}

Equations linearise(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                    CorrespondenceCache& pairs, const Pose& T, const Level& level) {
  Equations equations;
  for_each_residual(source, target, pairs, T, level, [&](const Residual& r) {
    equations.hessian += r.weight * r.jacobian * r.jacobian.transpose();
    equations.gradient += r.weight * r.value * r.jacobian;
    equations.cost += r.weight * r.value * r.value;
    equations.weight += r.weight;
    ++equations.pairs;
  });
  return equations;
}

/// Gauss-Newton step. A small damping keeps directions that no plane determines unchanged.
Vector6d step_of(const Equations& equations) {
  Matrix6d damped = equations.hessian;
  damped.diagonal() += Vector6d::Constant(1e-3 * equations.weight);
  return -damped.ldlt().solve(equations.gradient);
}

bool is_small(const Vector6d& step) {
  return step.head<3>().norm() < kStepTranslation && step.tail<3>().norm() < kStepRotation;
}

/// Covariance of the gradient: the sum of g g^T over surfaces, where g is the gradient of all
/// points on one surface. Points of one surface share the error of that surface, so that only
/// surfaces are independent.
Matrix6d gradient_covariance(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                             CorrespondenceCache& pairs, const Pose& T) {
  std::map<VoxelKey, Vector6d> gradients;  // sorted, so that sums have the same bits anywhere
  for_each_residual(source, target, pairs, T, kLevels.back(), [&](const Residual& r) {
    const VoxelKey surface = voxel_key(voxel_index(r.p_target / kSurfaceSize));
    gradients.try_emplace(surface, Vector6d::Zero()).first->second +=
        r.weight * r.value * r.jacobian;
  });
  Matrix6d sum = Matrix6d::Zero();
  for (const auto& [surface, g] : gradients) sum += g * g.transpose();
  return sum;
}

/// Covariance at T by the sandwich estimator of White (1980) for clustered errors: noise of single
/// points, which averages out, and errors of whole surfaces, which do not.
Covariance6 covariance_at(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                          CorrespondenceCache& pairs, const Pose& T, const Equations& equations) {
  const double variance = std::max(equations.cost / equations.weight, kMinSigma * kMinSigma);
  // A direction that no plane determines gets a standard deviation of one kilometre instead of
  // infinity.
  const Matrix6d information = equations.hessian / variance + 1e-6 * Matrix6d::Identity();
  const Matrix6d noise = information.ldlt().solve(Matrix6d::Identity());
  const Matrix6d surfaces = gradient_covariance(source, target, pairs, T) / (variance * variance);
  return noise + noise * surfaces * noise;
}

}  // namespace

Alignment align_point_to_plane(const std::vector<Eigen::Vector3f>& source,
                               const SurfaceCloud& target, const Pose& T_target_source_guess) {
  Alignment result;
  result.T_target_source = T_target_source_guess;
  CorrespondenceCache pairs(target.tree(), source.size());
  Equations equations;
  for (const Level& level : kLevels) {
    result.converged = false;
    for (int i = 0; i < level.iterations && !result.converged; ++i) {
      equations = linearise(source, target, pairs, result.T_target_source, level);
      if (equations.pairs < kMinPairs) return result;
      const Vector6d step = step_of(equations);
      result.T_target_source = perturbed(result.T_target_source, step);
      result.converged = is_small(step);
      ++result.iterations;
    }
  }
  result.covariance = covariance_at(source, target, pairs, result.T_target_source, equations);
  return result;
}

std::optional<Covariance6> point_to_plane_covariance(const std::vector<Eigen::Vector3f>& source,
                                                     const SurfaceCloud& target,
                                                     const Pose& T_target_source) {
  CorrespondenceCache pairs(target.tree(), source.size());
  const Equations equations = linearise(source, target, pairs, T_target_source, kLevels.back());
  if (equations.pairs < kMinPairs) return std::nullopt;
  return covariance_at(source, target, pairs, T_target_source, equations);
}

}  // namespace lidar_mapping::loop_closing
