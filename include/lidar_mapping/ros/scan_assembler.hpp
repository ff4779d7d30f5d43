// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/front_end/motion_prior.hpp"

namespace lidar_mapping::ros_border {

/// A scan with what the other sensors said of its stamp.
struct AssembledScan {
  Scan scan;                     ///< as it came
  front_end::MotionPrior prior;  ///< for FrontEnd::process()
};

/// Which sensors have a sample of the scan's stamp.
struct SyncedInputs {
  bool imu = false;       ///< a sample of the IMU comes
  bool velocity = false;  ///< a velocity comes
  bool gnss = false;      ///< a position comes
  /// The non-uniform rotation that was removed from the scan by the gyro.
  std::optional<UnevenTurning> uneven_turning = std::nullopt;
  /// Mean specific force since the previous scan.
  std::optional<FeltForce> felt = std::nullopt;
};

/// Puts together what preprocessing sends about one scan on several topics, which arrive in any
/// order: by equality of stamps, never by arrival. A scan waits for its SyncedInputs and for the
/// samples that these name. They are sent for every scan, so the result does not depend on the
/// order of arrival; what a full queue has lost is waited for until ten more scans are there.
/// Whoever sends scans without them has each scan wait for a topic until the next scan is there; a
/// topic that let a scan pass is not waited for until it speaks again. With an odometry from
/// outside, a scan waits until that odometry has passed its stamp, and gets the pose between the
/// two samples around it. One thread calls it.
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
  /// A pose of the outside odometry, at any stamp.
  void add_odometry(Stamp stamp, const Pose& T_external_base);
  /// A scan. Throws InputError if the stamp does not increase.
  void add_scan(Scan scan);

  /// The scans that are waited for no longer, oldest first.
  std::vector<AssembledScan> take_ready();
  /// All that wait: for when nothing has come for a while.
  std::vector<AssembledScan> flush();
  /// Scans for which the outside odometry had no pose; they were left out.
  std::size_t scans_without_odometry() const { return without_odometry_; }

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
  bool has_begun_ = false;  ///< a scan has left
  Stream<SyncedInputs> inputs_;
  Stream<ImuSample> imu_;
  Stream<VelocitySample> velocity_;
  Stream<GnssPosition> gnss_;
  std::map<Stamp, Pose> odometry_;
  std::deque<Scan> waiting_;
  std::optional<Stamp> newest_;
  std::size_t without_odometry_ = 0;
};

}  // namespace lidar_mapping::ros_border
