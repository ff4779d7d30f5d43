#pragma once

#include <Eigen/Core>

namespace lidar_mapping::front_end {

/// By how much an IMU's stamps are late, from how the turning that it followed differs from the
/// matched one: over a step that is the change of the rate times the delay. Weighted least squares
/// that forgets, beside a constant error, which is the bias.
class ImuDelay {
 public:
  /// The matched turning as seen from the followed one (rad), and the change of the rate over the
  /// step (rad/s), both in the axes of base_link.
  void update(const Eigen::Vector3d& error, const Eigen::Vector3d& change);
  /// Seconds to be subtracted from the stamps; 0 while nothing is sure.
  double seconds() const { return seconds_; }

 private:
  /// Weighted sums over the steps.
  struct Sums {
    double weight = 0.0;
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    double squared_error = 0.0;
    double squared_change = 0.0;
    double product = 0.0;
  };
  Sums sums_;
  double seconds_ = 0.0;
};

}  // namespace lidar_mapping::front_end
