// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/step_timer.hpp"

#include "judgement/step_judge.hpp"
#include "local_map/local_mapper.hpp"
#include "matching/sweep_matcher.hpp"
#include "motion/motion_predictor.hpp"
#include "motion/unobserved_travel.hpp"
#include "scan/sweep_clock.hpp"
#include "scan/sweep_sampler.hpp"
#include "start/false_standstill_recovery.hpp"
#include "start/map_initialization.hpp"
#include "tracking/tracker.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {

/// The sequential NDT: estimates pose and twist of each sweep by one match against hashed voxel
/// maps. The maps grow with the drive, and voxels far away are removed (doc/front_end_map.md).
class NdtTracker : public Tracker {
 public:
  explicit NdtTracker(const FrontEndConfig& config);

  /// Predicts, matches, judges, and updates the state.
  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  void set_viewpoint_at_origin() override;
  void restart() override;
  bool accepts_gyro(const MotionPrior& prior) const override {
    return predictor_.accepts_gyro(prior);
  }
  void finalize() override { initialization_.finalize(); }
  PointCloud local_map() const override { return state_.map.cloud(); }

 private:
  /// A scan to be tracked.
  struct Step {
    const Scan& scan;
    const MotionPrior& prior;
    double seconds;  ///< since the previous scan
  };

  Step sample(const Scan& scan, const MotionPrior& prior);
  TrackedScan begin_result() const;
  PredictedMotion predict(const Step& step);
  StepMatch match_scan(const Step& step, const PredictedMotion& predicted);
  void update(const Step& step, const PredictedMotion& predicted, const StepMatch& match,
              TrackedScan& result);
  void finish(TrackedScan& result);

  /// The same match, or one without the points on what moves, if there are any.
  SweepMatcher::Found match_without_moving_points(SweepMatcher::Found found,
                                                  const Prediction& beliefs);
  /// Matches from the pose that vertical structures gave to this filter, which is adopted.
  StepMatch match_from_vertical_structure(const MotionFilter& recovered);
  /// Completes the first scan with the motion that the match of the second one shows.
  void set_first_motion(const NdtMatch& second);
  /// Learns from an accepted match.
  void learn(const Step& step, const PredictedMotion& predicted, const StepMatch& match,
             const FrontEndStatus& status);
  /// Along directions that the planes do not observe, only the believed speed is known. Where
  /// vertical structures replace the rings, they observe the position.
  void update_unobserved_travel(const Step& step, const PredictedMotion& predicted,
                                const StepMatch& match);
  void update_map(const Scan& scan, const std::vector<Eigen::Vector3d>& degenerate_directions);
  void insert(const Scan& scan);

  /// In place of the steps above, until a map has begun. The origin is the pose of its first scan.
  void start(const Scan& scan, FrontEndStatus& status);
  /// In place of match and judgement, if the sensor coasted out of its map, so that nothing is left
  /// of it.
  void lose(const Step& step, TrackedScan& result);
  /// In place of update(), if the second scan of a map does not fit to the first one: starts the
  /// map again with the second scan, at its best match.
  void replace_first_scan(const Scan& scan, const StepMatch& match, FrontEndStatus& status);
  /// In place of update(), if tracking is lost: the pose coasts until a match is found, or until
  /// the map is started again at the predicted pose.
  void recover(const Step& step, TrackedScan& result);

  bool has_enough_points() const;
  void start_map(const Scan& scan, const Pose& T_odom_base);
  void discard_map();

  const double max_lost_time_;  ///< s
  TrackerState state_;
  SweepSampler sweep_;
  SweepClock clock_;
  std::size_t scans_ = 0;
  MotionPredictor predictor_;
  SweepMatcher matcher_;
  StepJudge judge_;
  LocalMapper mapper_;
  UnobservedTravel unobserved_travel_;
  MapInitialization initialization_;
  FalseStandstillRecovery false_standstill_;
  bool has_begun_ = false;  ///< a map was started since the last restart
  StepTimer timer_;
};

}  // namespace lidar_mapping::front_end
