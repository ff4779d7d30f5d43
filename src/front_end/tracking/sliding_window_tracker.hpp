// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/front_end/step_timer.hpp"
#include "lidar_mapping/registration/registration.hpp"

#include "judgement/step_belief.hpp"
#include "judgement/step_origin.hpp"
#include "key_frame_rule.hpp"
#include "local_map/key_frame_window.hpp"
#include "motion/unobserved_travel.hpp"
#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Matches scans against a window of the last key frames with any registration method. When a new
/// key frame enters the window, all key frames are joined and thinned out to one target. Scans are
/// thinned out and aligned, starting from a prediction with constant velocity. This is the scheme
/// of the baseline method (doc/registration.md). It is intended for comparing methods, because the
/// target is built anew each time.
class SlidingWindowTracker : public Tracker {
 public:
  explicit SlidingWindowTracker(const FrontEndConfig& config);

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  void restart() override;
  PointCloud local_map() const override { return window_.joint_cloud(Pose::Identity()); }

 private:
  /// The result from the best of several starting poses; T_target_source is T_odom_base.
  struct Match {
    registration::RegistrationResult result;
    bool rescued = false;
  };

  TrackedScan start(const Scan& scan, const MotionPrior& prior);
  void predict_twist(const MotionPrior& prior);
  Match match_from(const Pose& T_odom_base_start, const PointCloud& sample);
  Match match_scan(const PointCloud& sample, const Pose& predicted, double seconds);
  std::vector<Pose> other_starts(double seconds) const;
  TrackedScan evaluate(const Match& match, const Pose& predicted, double seconds) const;
  void judge(const Match& match, const Pose& predicted, double seconds, std::size_t points,
             FrontEndStatus& status);
  StepEvidence collect_evidence(const Match& match, const Pose& predicted, double seconds) const;
  void set_pose(TrackedScan& tracked, Stamp stamp, bool speed_is_measured);
  void update_unobserved_travel(const FrontEndStatus& status, double seconds,
                                bool speed_is_measured);
  void update_window(const PointCloud& cloud, TrackedScan& tracked);
  bool key_frame_due(const TrackedScan& tracked) const;
  void insert_key_frame(PointCloud cloud);

  const FrontEndConfig config_;
  KeyFrameRule rule_;
  std::unique_ptr<registration::Registration> registration_;
  KeyFrameWindow window_;
  UnobservedTravel unobserved_travel_;
  DoubtState doubt_;
  StepOrigin step_origin_;
  StepTimer timer_;
  Pose T_odom_base_;  ///< of the last scan
  Vector6d twist_ = Vector6d::Zero();
  Vector6d sweep_twist_ = Vector6d::Zero();  ///< twist with which sweeps are deskewed
  Stamp stamp_ = 0;
  Stamp tracked_stamp_ = 0;  ///< of the last scan that was not lost
  bool speed_known_ = false;
};

}  // namespace lidar_mapping::front_end
