#include "pcl_registration.hpp"

#include "fit.hpp"

namespace lidar_mapping::registration {

void PclRegistration::set_target(const PointCloud& target) {
  const PclCloud::Ptr cloud = to_pcl(target);
  has_target_ = cloud->size() >= kLeastPoints;
  if (has_target_) method().setInputTarget(cloud);
}

RegistrationResult PclRegistration::align(const PointCloud& source,
                                          const Pose& T_target_source_guess) {
  RegistrationResult result;
  result.T_target_source = T_target_source_guess;
  const PclCloud::Ptr cloud = to_pcl(source);
  if (!has_target_ || cloud->size() < kLeastPoints) return result;

  method().setInputSource(cloud);
  PclCloud aligned;
  method().align(aligned, T_target_source_guess.matrix().cast<float>());
  const Eigen::Matrix4f matrix = method().getFinalTransformation();
  if (!matrix.allFinite()) return result;

  result.T_target_source = Pose::from_matrix(matrix.cast<double>());
  const Outcome outcome = this->outcome();
  result.converged = outcome.converged;
  result.iterations = outcome.iterations;
  take_over(evaluate_fit(*method().getSearchMethodTarget(), *cloud, result.T_target_source,
                         fitness_max_range_),
            result);
  return result;
}

}  // namespace lidar_mapping::registration
