#pragma once

#include <Eigen/Core>

namespace lidar_mapping::front_end {

/// By how much an IMU's stamps are late, from how the turning that it followed differs from the
/// matched one: over a step that is the change of the rate times the delay. Weighted least squares
/// that forgets.
class ImuDelay {
 public:
  /// The matched turning as seen from the followed one (rad), and the change of the rate over the
  /// step (rad/s), both in the axes of base_link.
  void update(const Eigen::Vector3d& error, const Eigen::Vector3d& change);
  /// Seconds to be subtracted from the stamps; 0 while nothing is sure.
  double seconds() const { return seconds_; }

 private:
  double information_ = 0.0;  ///< sum of squared changes
  double product_ = 0.0;      ///< of changes and errors
  double squared_error_ = 0.0;
  double weight_ = 0.0;
  double seconds_ = 0.0;
};

}  // namespace lidar_mapping::front_end
