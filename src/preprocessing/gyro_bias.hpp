// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// Learns the bias of a gyro while the vehicle stands: over a second the rates and accelerations
/// are steady, the mean rate is small and the velocity, where there is one, is zero.
class GyroBias {
 public:
  /// In the order of the stamps. `standing` is what the velocity says at that time, if anything.
  void add(const ImuSample& sample, std::optional<bool> standing);
  /// By the samples up to `stamp`, in rad/s and in the sensor's axes; zero until the vehicle has
  /// stood once. What was learned later has no part in it: the value of an instant does not depend
  /// on when it is asked for. Estimates of the last 64 times of standing are kept.
  Eigen::Vector3d at(Stamp stamp) const;

 private:
  struct Estimate {
    Stamp stamp;  ///< of the last sample of its window
    Eigen::Vector3d bias;
  };

  void update(std::optional<bool> standing);

  std::deque<ImuSample> window_;
  std::deque<Estimate> estimates_;
};

}  // namespace lidar_mapping::preprocessing
