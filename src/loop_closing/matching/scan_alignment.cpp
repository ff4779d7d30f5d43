// SPDX-License-Identifier: BSD-3-Clause
#include "matching/scan_alignment.hpp"

#include "lidar_mapping/registration/registration.hpp"

namespace lidar_mapping::loop_closing {

namespace {

PointCloud cloud_of(const std::vector<Eigen::Vector3f>& points) {
  PointCloud cloud;
  cloud.points.reserve(points.size());
  for (const Eigen::Vector3f& p : points) cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  return cloud;
}

}  // namespace

ScanAlignment::ScanAlignment(const LoopClosingConfig& config) {
  if (config.registration_method.point_to_plane) return;
  registration::RegistrationConfig method = config.registration;
  method.method = config.registration_method.other;
  method.fitness_max_range = config.fitness_score_max_range;
  registration_ = registration::make_registration(method);
}

ScanAlignment::~ScanAlignment() = default;

Alignment ScanAlignment::align(const std::vector<Eigen::Vector3f>& source,
                               const SurfaceCloud& target, const Pose& T_target_source_guess) {
  if (registration_ == nullptr) return align_point_to_plane(source, target, T_target_source_guess);
  registration_->set_target(cloud_of(target.tree().points()));
  const registration::RegistrationResult registered =
      registration_->align(cloud_of(source), T_target_source_guess);
  Alignment result;
  result.T_target_source = registered.T_target_source;
  result.iterations = registered.iterations;
  const auto covariance = point_to_plane_covariance(source, target, registered.T_target_source);
  result.converged = registered.converged && covariance.has_value();
  if (covariance) result.covariance = *covariance;
  return result;
}

}  // namespace lidar_mapping::loop_closing
