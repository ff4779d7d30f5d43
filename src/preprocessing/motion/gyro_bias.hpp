// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// Learns the bias of a gyro while the vehicle stands still: over one second rates and
/// accelerations are steady, the mean rate is small, and the velocity is zero, if there is one.
class GyroBias {
 public:
  /// Adds samples in the order of their stamps. `standing` is the state according to the velocity
  /// at that time, if known.
  void add(const ImuSample& sample, std::optional<bool> standing);
  /// The bias from the samples up to `stamp`, in rad/s and in the sensor's axes; zero until the
  /// vehicle has stood still once. Later samples have no influence, so the value does not depend on
  /// the time of the query. The estimates of the last 64 standstills are kept.
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
