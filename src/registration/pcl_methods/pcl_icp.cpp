// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <pcl/registration/icp.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

using Criteria = pcl::registration::DefaultConvergenceCriteria<float>;

/// Iterative closest point, point to point (Besl and McKay 1992).
struct CountedIcp : pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> {
  PclRegistration::Outcome outcome() {
    const auto end = getConvergeCriteria()->getConvergenceState();
    return {hasConverged() && end != Criteria::CONVERGENCE_CRITERIA_ITERATIONS, nr_iterations_};
  }
};

}  // namespace

std::unique_ptr<Registration> make_icp(const RegistrationConfig& config) {
  const auto icp = std::make_shared<CountedIcp>();
  icp->setMaxCorrespondenceDistance(config.max_correspondence_distance);
  icp->setUseReciprocalCorrespondences(config.use_reciprocal_correspondences);
  icp->setMaximumIterations(config.max_iterations);
  // PCL compares the square of the step with its epsilon, and the cosine of the turn.
  icp->setTransformationEpsilon(std::pow(config.transformation_epsilon, 2));
  icp->setTransformationRotationEpsilon(std::cos(config.rotation_epsilon));
  // No end by a slow fall of the error: far from the solution it falls slowly too.
  icp->setEuclideanFitnessEpsilon(0.0);
  return std::make_unique<PclRegistration>(
      icp, [icp] { return icp->outcome(); }, config.fitness_max_range);
}

}  // namespace lidar_mapping::registration
