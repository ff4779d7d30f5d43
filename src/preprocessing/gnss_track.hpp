// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/antenna_fit.hpp"
#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

#include "fix_scatter.hpp"
#include "gnss_gate.hpp"
#include "heading_check.hpp"
#include "local_frame.hpp"
#include "motion_sensors.hpp"
#include "sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// What became of a fix: refused with a sentence why, or taken.
struct FixResult {
  Insertion insertion = Insertion::kRefused;
  std::string problem;
};

/// GNSS fixes as a track in the local frame. A first fix that is kilometres from the next two,
/// which agree, is left out, and the frame begins with these. Covariances that are too small for
/// the fixes' scatter are raised. Stamps that are late (or early) beside the measured motion are
/// named, and judged as if they were not, but left as they are: the back end, which knows
/// the whole drive, corrects them.
class GnssTrack {
 public:
  GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics);

  /// A taken fix waits until the motion up to it is known.
  FixResult add(GnssFix fix, const std::string& frame_id);
  /// Judges the fixes whose motion is known by now, or will not be (`latency` after them, or all).
  /// Returns what is wrong with those that it refuses.
  std::vector<std::string> evaluate_pending(MotionSensors& sensors, Stamp now, Stamp latency,
                                            bool all);
  /// Whether a fix at or after `stamp` may still come.
  bool may_still_deliver(Stamp stamp, Stamp now, Stamp latency) const;
  /// The antenna at `stamp` between two good fixes, with its lever arm; no orientation yet.
  std::optional<GnssPosition> at(Stamp stamp) const;
  /// Whether R_enu_base may be used at this position (imu_orientation).
  bool accepts_heading(const GnssPosition& position, const Eigen::Quaterniond& R_enu_base,
                       bool backwards);

  const SensorStream<LocalFix>& stream() const { return stream_; }
  bool has_fixes() const { return !stream_.buffer().empty() || !pending_fixes_.empty(); }
  const HeadingCheck& heading_check() const { return heading_check_; }
  const AntennaFit& antenna_fit() const { return antenna_fit_; }
  const FixScatter& scatter() const { return scatter_; }
  /// Nothing before two fixes agree: the first may be anywhere.
  std::optional<GeodeticDatum> datum() const;
  std::vector<Diagnostic> take_diagnostics() { return diagnostics_.take(); }
  void give_up_if_silent() {
    if (pending_fixes_.empty()) stream_.give_up_if_silent();
  }
  /// Forgets the fixes; the datum stays.
  void clear();

 private:
  struct PendingFix {
    GnssFix original;
    LocalFix fix;
    double applied_delay = 0.0;  ///< s, of its stamp, to be judged
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
  Stamp last_checked_ = 0;
  std::size_t accepted_count_ = 0;  ///< fixes, up to two
  std::optional<PendingFix>
      last_rejected_;  ///< was refused just before, while only the first is taken
  GnssGate gate_;
  FixScatter scatter_;
  AntennaFit antenna_fit_;
  double delay_ = 0.0;  ///< s, of the receiver's stamps
  SensorStream<LocalFix> stream_;
  std::string frame_id_;
  HeadingCheck heading_check_;
  DiagnosticLog diagnostics_;
};

}  // namespace lidar_mapping::preprocessing
