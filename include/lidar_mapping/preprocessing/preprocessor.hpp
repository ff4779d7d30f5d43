// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/felt_force.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"
#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/packed_points.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

namespace lidar_mapping::preprocessing {

/// A scan as measured: points in the sensor's frame, times (if any) relative to `stamp`.
struct RawScan {
  Stamp stamp = 0;       ///< of the message
  std::string frame_id;  ///< the sensor's
  PointCloud cloud;      ///< m; times in s
  /// The times were computed from absolute ones: they are relative to `stamp`, whatever
  /// `scan_stamp` is.
  bool times_are_absolute = false;
  /// Time span of the cloud's points, if the reader of the message knows it.
  std::optional<TimeSpan> time_span = std::nullopt;
  /// Location of the points if they have not been read yet; the cloud then has room for them.
  std::optional<PackedPoints> packed = std::nullopt;
  /// cloud_fingerprint() of the points as the driver sent them. Whoever moves them or appends
  /// others takes it before; otherwise the Preprocessor does.
  std::optional<std::uint64_t> fingerprint = std::nullopt;

  /// Reads the packed points into the cloud, if there are any.
  void unpack();
  /// Sets the fingerprint, if it is not known, to that of the points as they are.
  void take_fingerprint();
};

/// A scan in the LiDAR's own frame, with the values of the other sensors at its stamp. A value is
/// missing if the sensor is absent or has a gap there: nothing is extrapolated. The cloud has times
/// if the motion during the scan is still contained in it; imu->angular_velocity is then the mean
/// rate over the scan. If only the IMU's gyro was available, the remaining rotation is uniform, at
/// that rate.
struct SyncedScan {
  Scan scan;                               ///< the points in the LiDAR's frame
  std::string frame_id;                    ///< the LiDAR's
  Pose T_base_lidar;                       ///< its place on the vehicle
  std::optional<ImuSample> imu;            ///< in the axes of base_link
  std::optional<VelocitySample> velocity;  ///< of base_link
  std::optional<GnssPosition> gnss;        ///< of the antenna, East-North-Up
  /// The non-uniform rotation that was removed from the cloud by the gyro alone. The front end adds
  /// it again if it finds the gyro wrong.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  std::optional<FeltForce> felt = std::nullopt;  ///< since the previous scan
  /// Fingerprint of the points as the driver sent them: measured motion, which differs from stamp
  /// to stamp, moves the same points to other places.
  std::optional<std::uint64_t> fingerprint = std::nullopt;
};

/// Numbers of processed and dropped data since the start.
struct PreprocessingCounters {
  std::size_t scans_in = 0;                 ///< were given to process()
  std::size_t scans_out = 0;                ///< were handed on
  std::size_t scans_without_extrinsic = 0;  ///< no transform from the scan's frame to base_link
  std::size_t scans_without_points = 0;     ///< fewer than min_points after filtering
  std::size_t scans_out_of_order = 0;       ///< dropped for their stamp: older, equal or stray
  std::size_t scans_waiting_too_long = 0;   ///< completed early: the queue was full
  std::size_t scans_discarded = 0;          ///< were waiting when time went back
  std::size_t scans_deskewed = 0;           ///< motion fully compensated, so without times
  std::size_t points_not_finite = 0;        ///< left out
  std::size_t samples_refused = 0;          ///< not finite, duplicate or out of order
  /// No fix, implausible position, rejected by the gate, or too many waited for the motion.
  std::size_t gnss_refused = 0;
  std::size_t resets = 0;  ///< time went back by more than 2 s, and all buffers were emptied
};

/// Synchronises scans with the samples of the other sensors. It waits until each sensor in use has
/// a sample after the scan, or until its latency is over (in the time of the data). Then it
/// interpolates at the scan's stamp, deskews and filters. It uses no clock: time is defined by the
/// data. The class must be called from one thread.
class Preprocessor {
 public:
  /// The configuration is one that load() accepts. `lookup` is asked for the frames of all sensors.
  Preprocessor(const PreprocessingConfig& config, ExtrinsicLookup lookup);
  ~Preprocessor();

  /// Adds a sample of the IMU, in the axes of `frame_id` and the units of the configuration. Bad
  /// samples are counted and dropped.
  void add_imu(const ImuSample& sample, const std::string& frame_id);
  /// Adds a velocity of the frame `frame_id` in its axes. Bad ones are counted and dropped.
  void add_velocity(const VelocitySample& sample, const std::string& frame_id);
  /// Adds a fix of the antenna whose frame is `frame_id`. Bad ones are counted and dropped.
  void add_gnss(const GnssFix& fix, const std::string& frame_id);

  /// Queues a scan and returns the scans that are complete now, in order of their stamps.
  std::vector<SyncedScan> process(RawScan scan);
  /// The scans that were completed by samples added since the last call.
  std::vector<SyncedScan> take_complete();
  /// All waiting scans, complete or not: for the end of the data.
  std::vector<SyncedScan> flush();

  /// Origin of the East-North-Up frame. Unless it is configured, it is empty until two fixes agree
  /// (without gnss_gating: until the first fix).
  std::optional<GeodeticDatum> datum() const;
  /// Counts of the data processed, dropped and refused so far.
  const PreprocessingCounters& counters() const;
  /// Messages about observations and problems since the last call; each one is reported once.
  std::vector<Diagnostic> take_diagnostics();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::preprocessing
