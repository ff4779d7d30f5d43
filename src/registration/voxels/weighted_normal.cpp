// SPDX-License-Identifier: BSD-3-Clause
#include "voxels/weighted_normal.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::registration {
namespace {

/// From 0 at `none` to 1 at `all`.
double ramp(double value, double none, double all) {
  return std::clamp((value - none) / (all - none), 0.0, 1.0);
}

}  // namespace

Eigen::Vector3d weighted_normal(const Gaussian& gaussian, const PlaneModel& model,
                                double ring_isolation) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(gaussian.covariance);
  const Eigen::Vector3d values = solver.eigenvalues().cwiseMax(0.0);
  const double free = gaussian.count - 1.0;
  const double prior = model.prior_points;
  const double variance =
      (free * values[0] + prior * model.prior_sigma * model.prior_sigma) / (free + prior) +
      model.sigma * model.sigma;
  const double roundness = values[2] > 0.0 ? values[1] / values[2] : 0.0;
  const double trust = ramp(roundness, model.line_floor, model.line_ratio) *
                       ramp(std::sqrt(values[1]), model.least_breadth, model.sure_breadth);
  const double ratio = values[1] > 0.0 ? std::sqrt(values[0] / values[1]) : 1.0;
  const double steepness = 1.0 - ring_isolation * ramp(ratio, model.thin_ratio, model.thick_ratio);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0) * (trust / std::sqrt(variance));
  return {normal.x(), normal.y(), steepness * normal.z()};
}

}  // namespace lidar_mapping::registration
