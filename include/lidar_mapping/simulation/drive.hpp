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

/// An interval without a fix, in seconds after the beginning of the drive.
struct GnssOutage {
  double begin_s = 0.0;  ///< First instant without a fix, s.
  double end_s = 0.0;    ///< First instant with a fix again, s.
};

/// A jump of the fixes to the north-east for ten seconds, while their covariance stays as small as
/// before: the effect of a wrong ambiguity or of a reflection.
struct GnssJump {
  double at_s = 0.0;    ///< Beginning, s after the beginning of the drive.
  double metres = 0.0;  ///< Size of the jump, m.
};

/// What to simulate. The same options give the same values, bit for bit.
struct DriveOptions {
  std::string drive = "town";   ///< One of drive_names().
  std::string lidar = "hdl64";  ///< One of lidar_names().
  std::uint64_t seed = 1;       ///< Seed of the world, the traffic and all noise.
  /// Number of the pass, at most 36500: each gives another traffic and noise in the same world
  /// (towns only), so many days later.
  std::uint64_t pass = 0;
  /// The same route in the opposite direction, on the other lane: towns, `open_road`, `car_park`.
  bool reverse = false;
  /// Number of the day of the parked cars: each has other ones in the same world. For towns and
  /// `car_park`; 0: those of the seed.
  std::uint64_t parked = 0;
  double start = 0.0;              ///< Data before this time are left out, s.
  std::optional<double> duration;  ///< The drive ends after this time, s; none: the whole drive.
  int rounds = 2;                  ///< Rounds of the drive `city`; other drives ignore it.
  double scan_rate = 10.0;         ///< Turns of the LiDAR per second.
  double range_noise = 0.02;       ///< Standard deviation of the ranges, m.
  bool movers = true;              ///< Adds moving cars and people.
  bool undistorted = false;        ///< Takes each scan at one instant, without times of the points.
  double gnss_rate = 10.0;         ///< Fixes of GNSS per second.
  double gnss_noise = 0.02;  ///< Standard deviation east and north, m; 1.5 times as much upwards.
  std::vector<GnssOutage> gnss_outages;  ///< Intervals without a fix.
  std::vector<GnssJump> gnss_jumps;      ///< Jumps of the fixes.
  std::vector<ScanFault> scan_faults;    ///< Faults of the LiDAR.
  std::string imu = "good";              ///< One of imu_names().
  std::vector<ImuFault> imu_faults;      ///< Faults of the IMU.
};

/// Adds the fault that `text` describes, as parse_imu_fault() reads it if it begins with "imu_",
/// else as parse_scan_fault() does. Throws ConfigError.
void add_fault(DriveOptions& options, const std::string& text);

/// Poses of the sensors on the vehicle.
struct SensorMounting {
  Pose T_base_lidar;  ///< Pose of the LiDAR in base_link.
  Pose T_base_imu;    ///< Pose of the IMU in base_link.
  /// Position of the GNSS antenna in base_link, m.
  Eigen::Vector3d p_base_antenna = Eigen::Vector3d::Zero();
};

/// A scan: one turn of the LiDAR.
struct SimulatedScan {
  Stamp stamp = 0;  ///< Beginning of the turn, ns; jitter included.
  Stamp end = 0;    ///< End of the turn, ns.
  /// Points in the frame of the LiDAR; times are seconds after `stamp`, rounded to the firing of
  /// the column (none if undistorted).
  PointCloud cloud;
  std::vector<std::uint8_t> moving;  ///< 1 for each point on a moving object, else 0.
  /// Number of the ray of each point, as ray_directions() counts.
  std::vector<std::uint32_t> rays;
};

/// A simulated drive: a procedural world, an exact motion through it and the measurements of the
/// sensors. Only the world is stored; each scan is computed on demand from its index alone. Const
/// calls are safe from many threads.
class Drive {
 public:
  /// Builds the world. Throws ConfigError for an unknown drive or sensor, or a value out of range.
  explicit Drive(const DriveOptions& options);
  ~Drive();
  /// A drive that was moved from can only be destroyed or assigned to.
  Drive(Drive&&) noexcept;
  /// See the constructor.
  Drive& operator=(Drive&&) noexcept;

  /// The same drive with another LiDAR (one of lidar_names()) at another place, whose turns begin
  /// `phase` ns later. Throws ConfigError.
  Drive with_lidar(const std::string& lidar, const Pose& T_base_lidar, Stamp phase) const;

  /// Exact T_map_base over the drive; the map frame is East-North-Up at datum().
  const SmoothTrajectory& trajectory() const;
  /// Everything that rays can hit.
  const World& world() const;
  /// Poses of the sensors on the vehicle.
  const SensorMounting& mounting() const;
  /// Model of the LiDAR.
  const LidarModel& lidar() const;
  /// Geodetic origin of the map frame.
  GeodeticDatum datum() const;

  /// Number of scans.
  std::size_t scan_count() const;
  /// True beginning of the turn, ns.
  Stamp scan_stamp(std::size_t index) const;
  /// Stamp that the scan carries, ns: the same, unless stamps jitter.
  Stamp reported_stamp(std::size_t index) const;
  /// Computes a scan. Throws ConfigError if `index` is not less than scan_count().
  SimulatedScan scan(std::size_t index) const;
  /// The scan in base_link in the form that the stages process, for tests; its times are kept.
  Scan base_scan(std::size_t index) const;

  /// All samples of the IMU, in the axes of its frame: at 100 Hz on a car and in `walk`, else at
  /// 200 Hz.
  std::vector<ImuSample> imu() const;
  /// All velocities at 100 Hz: those of the IMU's frame in its axes.
  std::vector<VelocitySample> velocity() const;
  /// All fixes of the antenna at DriveOptions::gnss_rate. During an outage their status is -1.
  std::vector<GnssFix> gnss() const;

 private:
  class Impl;
  Drive(const DriveOptions& options, const Pose& T_base_lidar, Stamp phase);

  std::unique_ptr<Impl> impl_;
};

/// Names that DriveOptions::drive accepts.
std::vector<std::string> drive_names();
/// Names that DriveOptions::imu accepts.
std::vector<std::string> imu_names();

}  // namespace lidar_mapping::simulation
