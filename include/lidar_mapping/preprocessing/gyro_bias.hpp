#pragma once

#include <deque>
#include <optional>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// Learns the bias of a gyro while the vehicle stands: over a second the rates and accelerations
/// are steady, the mean rate is small and the velocity, where there is one, is zero.
class GyroBias {
 public:
  /// `standing` is what the velocity says at that time, if anything does.
  void add(const ImuSample& sample, std::optional<bool> standing);
  /// rad/s in the sensor's axes; zero until the vehicle has stood once.
  const Eigen::Vector3d& bias() const { return bias_; }
  bool is_known() const { return known_; }

 private:
  void judge(std::optional<bool> standing);

  std::deque<ImuSample> window_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  bool known_ = false;
};

}  // namespace lidar_mapping::preprocessing
