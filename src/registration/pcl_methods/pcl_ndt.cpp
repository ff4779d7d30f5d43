// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <pcl/registration/ndt.h>

#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

namespace {

/// The method of lidar_localization (Magnusson 2009, with the line search of More and Thuente
/// 1994). PCL's class, which gives access to its last step.
struct StepwiseNdt : pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> {
  double last_step() const { return transformation_.block<3, 1>(0, 3).norm(); }
  double last_turn() const {
    return Eigen::AngleAxisf(Eigen::Matrix3f(transformation_.block<3, 3>(0, 0))).angle();
  }
};

}  // namespace

std::unique_ptr<Registration> make_pcl_ndt(const RegistrationConfig& config) {
  const auto ndt = std::make_shared<StepwiseNdt>();
  const double step = config.transformation_epsilon, turn = config.rotation_epsilon;
  ndt->setResolution(static_cast<float>(config.resolution));
  ndt->setStepSize(config.step_size);
  ndt->setMaximumIterations(config.max_iterations);
  // PCL compares the square of the step with its epsilon, and the cosine of the turn.
  ndt->setTransformationEpsilon(step * step);
  ndt->setTransformationRotationEpsilon(std::cos(turn));
  const auto outcome = [ndt, step, turn]() -> PclRegistration::Outcome {
    return {ndt->last_step() <= step && ndt->last_turn() <= turn, ndt->getFinalNumIteration()};
  };
  return std::make_unique<PclRegistration>(ndt, outcome, config.fitness_max_range);
}

}  // namespace lidar_mapping::registration
