// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::ros_border {

/// A scan with the data of the other sensors at its stamp.
struct AssembledScan {
  Scan scan;                     ///< as received
  front_end::MotionPrior prior;  ///< for FrontEnd::process()
};

/// Sensors that have a sample of the scan's stamp.
struct SyncedInputs {
  bool imu = false;       ///< whether an IMU sample is sent
  bool velocity = false;  ///< whether a velocity is sent
  bool gnss = false;      ///< whether a position is sent
  /// The non-uniform rotation that was removed from the scan by the gyro.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  /// Mean specific force since the previous scan.
  std::optional<FeltForce> felt = std::nullopt;
  /// Of the points as the driver sent them.
  std::optional<std::uint64_t> fingerprint = std::nullopt;
};

/// Assembles the messages about one scan that preprocessing publishes on several topics, by equal
/// stamps, whatever the order of arrival. A scan waits for its SyncedInputs and for the samples
/// that these name. They are sent for every scan, so the result does not depend on the order of
/// arrival; a message that was lost in a full queue is waited for until ten newer scans have
/// arrived. Without SyncedInputs (scans of another program) a scan waits for each topic until the
/// next scan; a topic without a message for a scan is not waited for until its next message. With
/// an external odometry a scan waits until that odometry has passed its stamp, and gets the pose
/// interpolated between the two samples around it. One thread calls it.
class ScanAssembler {
 public:
  /// `external_odometry`: scans need a pose of add_odometry().
  explicit ScanAssembler(bool external_odometry);

  /// Which samples belong to the scan with this stamp.
  void add_inputs(Stamp stamp, const SyncedInputs& inputs);
  /// A sample at a scan's stamp, in the axes of base_link.
  void add_imu(const ImuSample& sample_base);
  /// The velocity of base_link in its axes at a scan's stamp.
  void add_velocity(const VelocitySample& sample_base);
  /// A position at a scan's stamp.
  void add_gnss(const GnssPosition& position);
  /// A pose of the external odometry, at any stamp.
  void add_odometry(Stamp stamp, const Pose& T_external_base);
  /// A scan. Throws InputError if the stamp does not increase.
  void add_scan(Scan scan);

  /// The scans that are complete or no longer wait, oldest first.
  std::vector<AssembledScan> take_ready();
  /// All waiting scans, to be processed when no message has arrived for a while.
  std::vector<AssembledScan> flush();
  /// Number of scans that were left out because the external odometry had no pose.
  std::size_t scans_without_odometry() const { return without_odometry_; }
  /// Number of scans that lack an IMU sample or a velocity that was sent, and was lost on its way.
  std::size_t scans_without_samples() const { return without_samples_; }

 private:
  template <typename Sample>
  struct Stream {
    std::map<Stamp, Sample> samples;
    bool expected = true;

    void add(Stamp stamp, const Sample& sample);
    bool has(Stamp stamp) const { return samples.count(stamp) > 0; }
    bool complete_for(Stamp stamp, bool last_chance);
    std::optional<Sample> take(Stamp stamp);
  };

  bool ready(Stamp stamp);
  bool has_named_samples(Stamp stamp, const SyncedInputs& inputs) const;
  bool odometry_ready(Stamp stamp) const;
  void emit_first(std::vector<AssembledScan>& out);
  std::optional<Pose> odometry_at(Stamp stamp) const;

  bool external_odometry_;
  bool has_begun_ = false;  ///< whether a scan was returned
  Stream<SyncedInputs> inputs_;
  Stream<ImuSample> imu_;
  Stream<VelocitySample> velocity_;
  Stream<GnssPosition> gnss_;
  std::map<Stamp, Pose> odometry_;
  std::deque<Scan> waiting_;
  std::optional<Stamp> newest_;
  std::size_t without_odometry_ = 0;
  std::size_t without_samples_ = 0;
};

}  // namespace lidar_mapping::ros_border
