// SPDX-License-Identifier: BSD-3-Clause
#include "pcl_methods/pcl_registration.hpp"

#include <utility>

#include "fit.hpp"

namespace lidar_mapping::registration {

PclRegistration::PclRegistration(std::shared_ptr<PclMethod> method,
                                 std::function<Outcome()> outcome, double fitness_max_range)
    : method_(std::move(method)),
      outcome_(std::move(outcome)),
      fitness_max_range_(fitness_max_range) {}

void PclRegistration::set_target(const PointCloud& target) {
  const PclCloud::Ptr cloud = to_pcl(target);
  has_target_ = cloud->size() >= kLeastPoints;
  if (!has_target_) return;
  // By whole metres: the usual voxels stay where they are.
  T_target_middle_ = {Eigen::Quaterniond::Identity(), middle_of(*cloud).array().round()};
  const Eigen::Vector3d& middle = T_target_middle_.translation;
  for (pcl::PointXYZ& p : *cloud) {
    p.getVector3fMap() = (p.getVector3fMap().cast<double>() - middle).cast<float>();
  }
  method_->setInputTarget(cloud);
}

RegistrationResult PclRegistration::align(const PointCloud& source,
                                          const Pose& T_target_source_guess) {
  RegistrationResult result;
  result.T_target_source = T_target_source_guess;
  const PclCloud::Ptr cloud = to_pcl(source);
  if (!has_target_ || cloud->size() < kLeastPoints) return result;

  method_->setInputSource(cloud);
  PclCloud aligned;
  const Pose T_middle_guess = T_target_middle_.inverse() * T_target_source_guess;
  method_->align(aligned, T_middle_guess.matrix().cast<float>());
  const Eigen::Matrix4f matrix = method_->getFinalTransformation();
  if (!matrix.allFinite()) return result;

  const Pose T_middle_source = Pose::from_matrix(matrix.cast<double>());
  result =
      evaluate_fit(*method_->getSearchMethodTarget(), *cloud, T_middle_source, fitness_max_range_);
  result.T_target_source = T_target_middle_ * T_middle_source;
  const Outcome outcome = outcome_();
  result.converged = outcome.converged;
  result.iterations = outcome.iterations;
  return result;
}

}  // namespace lidar_mapping::registration
