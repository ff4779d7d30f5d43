// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <pcl/registration/icp.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

using Criteria = pcl::registration::DefaultConvergenceCriteria<float>;

struct CountedIcp : pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> {
  int iterations() const { return nr_iterations_; }
};

/// Iterative closest point, point to point (Besl and McKay 1992).
class PclIcp : public PclRegistration {
 public:
  explicit PclIcp(const RegistrationConfig& config) : PclRegistration(config.fitness_max_range) {
    icp_.setMaxCorrespondenceDistance(config.max_correspondence_distance);
    icp_.setUseReciprocalCorrespondences(config.use_reciprocal_correspondences);
    icp_.setMaximumIterations(config.max_iterations);
    // PCL compares the square of the step with its epsilon, and the cosine of the turn.
    icp_.setTransformationEpsilon(std::pow(config.transformation_epsilon, 2));
    icp_.setTransformationRotationEpsilon(std::cos(config.rotation_epsilon));
    // No end by a slow fall of the error: far from the solution it falls slowly too.
    icp_.setEuclideanFitnessEpsilon(0.0);
  }

 private:
  PclMethod& method() override { return icp_; }
  Outcome outcome() override {
    const auto end = icp_.getConvergeCriteria()->getConvergenceState();
    return {icp_.hasConverged() && end != Criteria::CONVERGENCE_CRITERIA_ITERATIONS,
            icp_.iterations()};
  }

  CountedIcp icp_;
};

}  // namespace

std::unique_ptr<Registration> make_icp(const RegistrationConfig& config) {
  return std::make_unique<PclIcp>(config);
}

}  // namespace lidar_mapping::registration
