// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/antenna_fit.hpp"
#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

#include "checks/heading_check.hpp"
#include "gnss/fix_scatter.hpp"
#include "gnss/gnss_gate.hpp"
#include "gnss/local_frame.hpp"
#include "motion/motion_sensors.hpp"
#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// The result for a fix: accepted, or rejected with a message.
struct FixResult {
  Insertion insertion = Insertion::kRefused;
  std::string problem;
};

/// The track of GNSS fixes in the local frame. If the first fix is kilometres away from the next
/// two, which agree with each other, it is discarded, and the frame begins at the earlier one of
/// these two. If the fixes scatter more than their covariances state, the covariances are
/// increased. If the stamps are late (or early) compared with the measured motion, this is
/// reported, and later fixes are checked at stamps from which the delay is taken off. Positions
/// keep the stamps of their fixes, moved by `gnss_time_offset` alone: the back end, which knows the
/// whole drive, corrects them.
class GnssTrack {
 public:
  GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics);

  /// Adds a fix. An accepted fix waits until the motion up to it is known.
  FixResult add(GnssFix fix, const std::string& frame_id);
  /// Checks the fixes whose motion is known by now, or will not become known (the latency after
  /// them, or all of them where waiting ends). Returns the problems of the rejected fixes, and of
  /// those that were dropped since the last call because too many waited.
  std::vector<std::string> evaluate_pending(MotionSensors& sensors, const Progress& progress,
                                            Waiting waiting);
  /// True if a fix at or after `stamp` may still arrive.
  bool may_still_deliver(Stamp stamp, const Progress& progress) const;
  /// The position of the antenna at `stamp`, interpolated between two good fixes, with its lever
  /// arm; without orientation.
  std::optional<GnssPosition> at(Stamp stamp) const;
  /// True if R_enu_base may be used at this position (imu_orientation).
  bool accepts_heading(const GnssPosition& position, const Eigen::Quaterniond& R_enu_base,
                       bool backwards);

  const SensorStream<LocalFix>& stream() const { return stream_; }
  const HeadingCheck& heading_check() const { return heading_check_; }
  const AntennaFit& antenna_fit() const { return antenna_fit_; }
  const FixScatter& scatter() const { return scatter_; }
  /// Empty until two fixes agree, because the first one may be completely wrong.
  std::optional<GeodeticDatum> datum() const;
  std::vector<Diagnostic> take_diagnostics() { return diagnostics_.take(); }
  void give_up_if_silent() {
    if (pending_fixes_.empty()) stream_.give_up_if_silent();
  }
  /// Removes the fixes; the datum is kept.
  void clear();

 private:
  struct PendingFix {
    GnssFix original;
    LocalFix fix;
    double applied_delay = 0.0;  ///< s that are taken off the stamp of `fix` for the check only
  };

  bool confirms_other_start(const PendingFix& pending) const;
  void restart_from(PendingFix first, PendingFix& second, const MotionSensors& sensors);
  void accept(PendingFix pending);
  std::string check(const PendingFix& pending, const MotionSensors& sensors);
  std::optional<Pose> motion_since_last_fix(Stamp stamp, const MotionSensors& sensors) const;
  Eigen::Vector3d lever_arm() const;
  std::optional<Eigen::Vector3d> antenna_velocity(Stamp stamp, const MotionSensors& sensors) const;
  void update_antenna_fit(const PendingFix& pending, const MotionSensors& sensors);
  void update_delay();

  PreprocessingConfig config_;
  const Extrinsics& extrinsics_;
  LocalFrame local_frame_;
  std::deque<PendingFix> pending_fixes_;  ///< in the order of their stamps
  std::size_t dropped_ = 0;               ///< of these because too many waited, not reported yet
  Stamp last_checked_ = 0;
  std::size_t accepted_count_ = 0;  ///< number of accepted fixes, at most two
  std::optional<PendingFix> last_rejected_;
  GnssGate gate_;
  FixScatter scatter_;
  AntennaFit antenna_fit_;
  double delay_ = 0.0;  ///< s by which stamps are late beside IMU and velocity; negative: early
  SensorStream<LocalFix> stream_;
  std::string frame_id_;
  HeadingCheck heading_check_;
  DiagnosticLog diagnostics_;
};

}  // namespace lidar_mapping::preprocessing
