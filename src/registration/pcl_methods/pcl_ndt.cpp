// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <pcl/registration/ndt.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

/// PCL's NDT, which gives access to its last step.
class StepwiseNdt : public pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> {
 public:
  double last_step() const { return transformation_.block<3, 1>(0, 3).norm(); }
  double last_turn() const {
    return Eigen::AngleAxisf(Eigen::Matrix3f(transformation_.block<3, 3>(0, 0))).angle();
  }
};

/// The method of lidar_localization (Magnusson 2009, with the line search of More and Thuente
/// 1994).
class PclNdt : public PclRegistration {
 public:
  explicit PclNdt(const RegistrationConfig& config)
      : PclRegistration(config.fitness_max_range),
        transformation_epsilon_(config.transformation_epsilon),
        rotation_epsilon_(config.rotation_epsilon) {
    ndt_.setResolution(static_cast<float>(config.resolution));
    ndt_.setStepSize(config.step_size);
    ndt_.setMaximumIterations(config.max_iterations);
    // PCL compares the square of the step with its epsilon, and the cosine of the turn.
    ndt_.setTransformationEpsilon(transformation_epsilon_ * transformation_epsilon_);
    ndt_.setTransformationRotationEpsilon(std::cos(rotation_epsilon_));
  }

 private:
  PclMethod& method() override { return ndt_; }
  Outcome outcome() override {
    return {ndt_.last_step() <= transformation_epsilon_ && ndt_.last_turn() <= rotation_epsilon_,
            ndt_.getFinalNumIteration()};
  }

  double transformation_epsilon_;
  double rotation_epsilon_;
  StepwiseNdt ndt_;
};

}  // namespace

std::unique_ptr<Registration> make_pcl_ndt(const RegistrationConfig& config) {
  return std::make_unique<PclNdt>(config);
}

}  // namespace lidar_mapping::registration
