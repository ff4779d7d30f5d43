// SPDX-License-Identifier: BSD-3-Clause
#include "imu/vertical.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Sign of the accelerations: most of them point upwards in base_link, because a vehicle is
/// upright.
double acceleration_sign(const DriveGraph& drive) {
  double vote_sum = 0.0;
  for (const DriveImu& imu : drive.imu) {
    if (imu.sample.linear_acceleration.isZero(0.0)) continue;  // not measured
    vote_sum += imu.sample.linear_acceleration.z() > 0.0 ? 1.0 : -1.0;
  }
  return vote_sum < 0.0 ? -1.0 : 1.0;
}

/// Length of the acceleration at rest as this sensor measures it, m/s^2, as the median: vehicles
/// rarely accelerate. Gravity differs by 0.3 % between places, and the scale of sensors by more.
double measured_gravity(const DriveGraph& drive) {
  std::vector<double> lengths;
  for (const DriveImu& imu : drive.imu) {
    const double length = imu.sample.linear_acceleration.norm();
    if (length > 0.0) lengths.push_back(length);
  }
  return median(std::move(lengths));
}

Vertical vertical_by_orientation(const DriveImu& imu, double stddev) {
  return {imu.node, imu.sample.orientation->conjugate() * Eigen::Vector3d::UnitZ(), stddev};
}

Vertical vertical_by_acceleration(const DriveImu& imu, double sign, double gravity,
                                  const BackEndConfig& config) {
  const Eigen::Vector3d& acceleration = imu.sample.linear_acceleration;
  const double excess = std::abs(acceleration.norm() - gravity) / gravity;
  // Braking by a changes the length by a^2 / 2g, but the direction by a / g.
  const double tilt_error = std::sqrt(2.0 * excess);
  return {imu.node, sign * acceleration.normalized(),
          std::hypot(config.imu_acceleration_stddev, tilt_error)};
}

}  // namespace

std::vector<Vertical> verticals(const DriveGraph& drive, const BackEndConfig& config) {
  std::vector<Vertical> result;
  const double sign = acceleration_sign(drive);
  const double gravity = measured_gravity(drive);
  const double stddev = drive.tilt_stddev.value_or(config.imu_orientation_stddev);
  for (const DriveImu& imu : drive.imu) {
    if (config.enable_imu_orientation && imu.sample.orientation) {
      result.push_back(vertical_by_orientation(imu, stddev));
    }
    if (config.enable_imu_acceleration && imu.sample.linear_acceleration.norm() > 0.0) {
      result.push_back(vertical_by_acceleration(imu, sign, gravity, config));
    }
  }
  return result;
}

}  // namespace lidar_mapping::back_end
