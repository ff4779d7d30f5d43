// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::registration {

/// How well a source cloud fits onto a target cloud, and where.
struct RegistrationResult {
  Pose T_target_source;    ///< where the source fits best
  bool converged = false;  ///< the last step was below the thresholds before the iterations ran out
  int iterations = 0;      ///< number of steps
  double fitness = 0.0;    ///< mean squared distance of paired points, m^2
  double inlier_fraction = 0.0;  ///< pairs that the robust kernel believes / points of the source
  double overlap = 0.0;          ///< points of the source with a partner / points of the source
  /// Gauss-Newton Hessian for perturbed(T_target_source, d); scaled so that its inverse is the
  /// covariance that the residuals suggest. Zero if the method gives none.
  Matrix6d hessian = Matrix6d::Zero();
};

/// A method that aligns point clouds. Implementations differ in the target's representation; all
/// keep the same meaning of the result. One thread calls an object at a time.
class Registration {
 public:
  virtual ~Registration() = default;
  /// Builds the target's representation. An empty cloud makes align() return converged = false.
  virtual void set_target(const PointCloud& target) = 0;
  /// Aligns `source` from the guess. A poor match is no error: see the result.
  virtual RegistrationResult align(const PointCloud& source, const Pose& T_target_source_guess) = 0;
};

/// The method that config.registration_method names.
std::unique_ptr<Registration> make_registration(const RegistrationConfig& config);

}  // namespace lidar_mapping::registration
