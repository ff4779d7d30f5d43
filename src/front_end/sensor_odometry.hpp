// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/front_end/step_timer.hpp"
#include "lidar_mapping/front_end/sweep_times.hpp"

#include "key_frame_maker.hpp"
#include "motion/vertical_ride_detector.hpp"
#include "scan/isolated_point_filter.hpp"
#include "tracking/sweep_times_validator.hpp"
#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Odometry of the frame that the scans are in, which is called base here; it begins at its first
/// pose. A scan takes this way: its stamp is checked, the times of its points are corrected, points
/// without neighbours are left out, the tracker finds the pose, and the result becomes a key frame
/// if it is due.
class SensorOdometry {
 public:
  explicit SensorOdometry(const FrontEndConfig& config);

  /// See FrontEnd.
  FrontEndResult process(const Scan& received, const MotionPrior& prior);
  std::vector<FrontEndResult> finalize();
  PointCloud local_map() const { return tracker_->local_map(); }

  bool has_begun() const { return last_stamp_.has_value(); }
  /// The last angular velocity, rad/s.
  Eigen::Vector3d angular_velocity() const;
  /// The next scan begins a new segment at the origin.
  void resume(KeyFrameIndex next_index, std::uint32_t next_segment);
  /// Tells that the scans are in the LiDAR's own frame.
  void set_viewpoint_at_origin();

 private:
  /// A provisional scan, and the points of its key frame, if it becomes one.
  struct ProvisionalScan {
    FrontEndResult result;
    TrackedScan tracked;
    PointCloud points;
  };

  void check_stamp(Stamp stamp) const;
  bool is_repeated(const PointCloud& cloud, const MotionPrior& prior);
  FrontEndResult coast(Stamp stamp);
  PointCorrection correction_of(const MotionPrior& prior) const;
  static std::optional<Scan> changed_scan(const Scan& scan, const MotionPrior& prior,
                                          const PointCorrection& correction);
  MotionPrior with_valid_rate(const MotionPrior& prior) const;
  static void state_times(const PointCorrection& correction, TrackedScan& tracked);
  bool try_other_times(const Scan& scan, const MotionPrior& prior, TrackedScan& tracked,
                       std::vector<FrontEndResult>& finalized);
  void check_vertical_ride(Stamp stamp, const MotionPrior& prior, TrackedScan& tracked);
  FrontEndResult result_of(Stamp stamp, const TrackedScan& tracked);
  Covariance6 add_step(const TrackedScan& from, const TrackedScan& to);
  void start_segment();
  std::vector<FrontEndResult> finalize_provisional(const std::vector<Revision>& revisions);
  FrontEndResult finalized_scan(ProvisionalScan provisional);

  bool matches_scans_;  ///< false if the odometry is external
  StepTimer timer_;
  std::optional<std::uint64_t> last_fingerprint_;  ///< of the previous scan, if it has one
  IsolatedPointFilter isolated_point_filter_;
  std::unique_ptr<Tracker> tracker_;
  std::optional<SweepTimesValidator> times_validator_;  ///< empty if finished, or if there is none
  SweepTimesRule times_;
  VerticalRideDetector ride_detector_;
  KeyFrameMaker key_frames_;
  std::vector<ProvisionalScan> provisional_;
  std::optional<TrackedScan> last_;  ///< of the segment, where the next step begins
  std::optional<Stamp> last_stamp_;
  std::optional<TrackedScan> tracked_;  ///< the last scan that was given to the tracker
  Stamp tracked_stamp_ = 0;
  std::uint32_t segment_ = 0;
};

}  // namespace lidar_mapping::front_end
