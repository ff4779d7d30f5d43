// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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

/// A scan as the sensor gave it: points in the sensor's frame, times (if any) relative to `stamp`.
struct RawScan {
  Stamp stamp = 0;
  std::string frame_id;
  PointCloud cloud;
  /// The times came from absolute ones: they refer to `stamp` whatever `scan_stamp` says.
  bool times_are_absolute = false;
  /// Of the cloud's times, where the reader of the message knows it.
  std::optional<TimeSpan> time_span = std::nullopt;
  /// Where the points have not been read yet; the cloud has the room for them.
  std::optional<PackedPoints> packed = std::nullopt;

  /// Reads the points that are packed.
  void unpack();
};

/// A scan in the LiDAR's own frame and what the other sensors measured at its stamp. No value where
/// a sensor is absent or has a gap there: nothing is extrapolated. The cloud has times if the
/// motion during the scan is still in it; where only the IMU's gyro was there, the turning that
/// remains is uniform, at the rate imu->angular_velocity.
struct SyncedScan {
  Scan scan;
  std::string frame_id;  ///< the LiDAR's
  Pose T_base_lidar;
  std::optional<ImuSample> imu;            ///< in the axes of base_link
  std::optional<VelocitySample> velocity;  ///< of base_link
  std::optional<GnssPosition> gnss;
  /// What the gyro alone has taken out of the cloud: whoever finds it wrong puts it back.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  std::optional<FeltForce> felt = std::nullopt;  ///< since the scan before
};

/// What was dropped, and why, since the start.
struct PreprocessingCounters {
  std::size_t scans_in = 0;
  std::size_t scans_out = 0;
  std::size_t scans_without_extrinsic = 0;  ///< no transform from the scan's frame to base_link
  std::size_t scans_without_points = 0;     ///< empty after filtering
  std::size_t scans_out_of_order = 0;
  std::size_t scans_waiting_too_long = 0;  ///< completed early: the queue was full
  std::size_t scans_forgotten = 0;         ///< were waiting when time went back
  std::size_t scans_deskewed = 0;
  std::size_t points_not_finite = 0;
  std::size_t samples_refused = 0;  ///< not finite, duplicate or out of order
  std::size_t gnss_refused = 0;     ///< no fix, implausible position, gated
  std::size_t resets = 0;           ///< time went back beyond the buffers
};

/// Brings scans and the samples of the other sensors together: waits until each sensor in use has a
/// sample after the scan (or its latency has passed, in data time), interpolates at the scan's
/// stamp, deskews and filters. It owns no clock: time is what the data say. One thread calls it.
class Preprocessor {
 public:
  using ExtrinsicLookup = preprocessing::ExtrinsicLookup;

  /// Throws ConfigError for a configuration that contradicts itself.
  Preprocessor(const PreprocessingConfig& config, ExtrinsicLookup lookup);
  ~Preprocessor();

  /// Samples of the other sensors, in the axes of `frame_id`. Bad ones are counted and dropped.
  void add_imu(const ImuSample& sample, const std::string& frame_id);
  void add_velocity(const VelocitySample& sample, const std::string& frame_id);
  void add_gnss(const GnssFix& fix, const std::string& frame_id);

  /// Queues a scan and returns the scans that are complete now, in order of their stamps.
  std::vector<SyncedScan> process(RawScan scan);
  /// The scans that have become complete through samples added since.
  std::vector<SyncedScan> take_complete();
  /// The waiting scans as they are: for the end of the data.
  std::vector<SyncedScan> flush();

  /// Origin of the East-North-Up frame, once there was a good fix.
  std::optional<GeodeticDatum> datum() const;
  const PreprocessingCounters& counters() const;
  /// Sentences about what was found or went wrong since the last call, each said once.
  std::vector<Diagnostic> take_diagnostics();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::preprocessing
