// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/registration/gicp.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

/// Generalised ICP, plane to plane (Segal, Haehnel and Thrun 2009).
struct CountedGicp : pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> {
  PclRegistration::Outcome outcome() {
    return {hasConverged() && nr_iterations_ < getMaximumIterations(), nr_iterations_};
  }
};

}  // namespace

std::unique_ptr<Registration> make_gicp(const RegistrationConfig& config) {
  const auto gicp = std::make_shared<CountedGicp>();
  gicp->setMaxCorrespondenceDistance(config.max_correspondence_distance);
  gicp->setCorrespondenceRandomness(config.correspondence_randomness);
  gicp->setMaximumOptimizerIterations(config.max_optimizer_iterations);
  gicp->setMaximumIterations(config.max_iterations);
  gicp->setTransformationEpsilon(config.transformation_epsilon);
  gicp->setRotationEpsilon(config.rotation_epsilon);
  return std::make_unique<PclRegistration>(
      gicp, [gicp] { return gicp->outcome(); }, config.fitness_max_range);
}

}  // namespace lidar_mapping::registration
