// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/simulation/imu_faults.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"
#include "lidar_mapping/simulation/scan_faults.hpp"
#include "lidar_mapping/simulation/smooth_trajectory.hpp"
#include "lidar_mapping/simulation/world.hpp"

namespace lidar_mapping::simulation {

/// An interval without a fix, seconds after the drive's beginning.
struct GnssOutage {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// From `at_s` on, fixes lie `metres` to the north-east of the truth while their covariance stays
/// as confident as before, for ten seconds: a wrong ambiguity or a reflection.
struct GnssJump {
  double at_s = 0.0;
  double metres = 0.0;
};

/// What to simulate. The same options give the same values, bit for bit.
struct DriveOptions {
  std::string drive = "town";      ///< one of drive_names()
  std::string lidar = "hdl64";     ///< one of lidar_names()
  std::uint64_t seed = 1;          ///< of the world, the traffic and all noise
  std::uint64_t pass = 0;          ///< others: another day in that world, with traffic and noise
                                   ///< of its own (the towns)
  double start = 0.0;              ///< s; what was before is left out
  std::optional<double> duration;  ///< s; cut the drive after this time
  int rounds = 2;                  ///< turns of `city`; other drives ignore it
  double scan_rate = 10.0;         ///< turns per second
  double range_noise = 0.02;       ///< m, standard deviation
  bool movers = true;              ///< moving cars and people
  bool undistorted = false;        ///< take each scan in one instant; no time per point
  double gnss_rate = 10.0;         ///< fixes per second
  double gnss_noise = 0.02;        ///< m, standard deviation east and north; 1.5 times that upwards
  std::vector<GnssOutage> gnss_outages;
  std::vector<GnssJump> gnss_jumps;
  std::vector<ScanFault> scan_faults;
  std::string imu = "good";  ///< one of imu_names()
  std::vector<ImuFault> imu_faults;
};

/// Adds what parse_scan_fault or parse_imu_fault make of `text`. Throws ConfigError.
void add_fault(DriveOptions& options, const std::string& text);

/// Where the sensors sit on the vehicle.
struct SensorMounting {
  Pose T_base_lidar;
  Pose T_base_imu;
  Eigen::Vector3d p_base_antenna = Eigen::Vector3d::Zero();
};

/// A turn of the LiDAR. Points are in the LiDAR's frame; `cloud.times` are seconds after `stamp`
/// (none if undistorted), quantised to the column.
struct SimulatedScan {
  Stamp stamp = 0;
  Stamp end = 0;  ///< when the turn is complete
  PointCloud cloud;
  std::vector<std::uint8_t> moving;  ///< per point: 1 on a moving object
  std::vector<std::uint32_t> rays;   ///< per point: its ray, as ray_directions() counts
};

/// A simulated drive: a procedural world, an exact motion through it and what the sensors measure.
/// Nothing is stored but the world; each scan is computed when asked for, from its index alone.
/// Const calls are safe from many threads.
class Drive {
 public:
  /// Throws ConfigError for an unknown drive or LiDAR or a value out of range.
  explicit Drive(const DriveOptions& options);
  ~Drive();
  Drive(Drive&&) noexcept;
  Drive& operator=(Drive&&) noexcept;

  /// Exact T_map_base over the drive; map is East-North-Up at datum().
  const SmoothTrajectory& trajectory() const;
  const World& world() const;
  const SensorMounting& mounting() const;
  const LidarModel& lidar() const;
  GeodeticDatum datum() const;

  std::size_t scan_count() const;
  /// When the turn begins.
  Stamp scan_stamp(std::size_t index) const;
  /// The stamp that the scan comes with: the same, unless stamps jitter.
  Stamp reported_stamp(std::size_t index) const;
  SimulatedScan scan(std::size_t index) const;
  /// The scan in base_link as the stages take it; `times` are kept.
  Scan base_scan(std::size_t index) const;

  /// All samples of the drive: IMU at 100 Hz on a car and in `walk`, else 200 Hz; velocity at
  /// 100 Hz, fixes at 10 Hz. The IMU and the velocity are those of the
  /// IMU's frame in its axes; fixes are those of the antenna. In an outage a fix has status -1.
  std::vector<ImuSample> imu() const;
  std::vector<VelocitySample> velocity() const;
  std::vector<GnssFix> gnss() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Names that DriveOptions::drive takes.
std::vector<std::string> drive_names();
/// Names that DriveOptions::imu takes.
std::vector<std::string> imu_names();

}  // namespace lidar_mapping::simulation
