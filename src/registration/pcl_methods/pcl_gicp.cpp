// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/registration/gicp.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

struct CountedGicp : pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> {
  int iterations() const { return nr_iterations_; }
};

/// Generalised ICP, plane to plane (Segal, Haehnel and Thrun 2009).
class PclGicp : public PclRegistration {
 public:
  explicit PclGicp(const RegistrationConfig& config) : PclRegistration(config.fitness_max_range) {
    gicp_.setMaxCorrespondenceDistance(config.max_correspondence_distance);
    gicp_.setCorrespondenceRandomness(config.correspondence_randomness);
    gicp_.setMaximumOptimizerIterations(config.max_optimizer_iterations);
    gicp_.setMaximumIterations(config.max_iterations);
    gicp_.setTransformationEpsilon(config.transformation_epsilon);
    gicp_.setRotationEpsilon(config.rotation_epsilon);
  }

 private:
  PclMethod& method() override { return gicp_; }
  Outcome outcome() override {
    return {gicp_.hasConverged() && gicp_.iterations() < gicp_.getMaximumIterations(),
            gicp_.iterations()};
  }

  CountedGicp gicp_;
};

}  // namespace

std::unique_ptr<Registration> make_gicp(const RegistrationConfig& config) {
  return std::make_unique<PclGicp>(config);
}

}  // namespace lidar_mapping::registration
