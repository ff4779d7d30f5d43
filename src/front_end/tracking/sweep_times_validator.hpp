// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/front_end/sweep_times.hpp"

#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Mean of numbers, and how certain it is.
class RunningMean {
 public:
  void add(double value);
  int count() const { return count_; }
  double mean() const { return mean_; }
  /// Standard deviation of the mean, for independent numbers; infinite for fewer than two.
  double sigma() const;

 private:
  int count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;  ///< sum of squared differences from the mean
};

/// Median of the latest numbers.
class RecentMedian {
 public:
  void add(double value);
  double median() const;
  void clear() { values_.clear(); }

 private:
  std::deque<double> values_;
};

/// Finds out whether the times of the points are right. At the begin of a drive the scans are also
/// tracked with other times, each by a tracker of its own with its own local map, and once more
/// with the given ones. With the right times the points fit to their map better. The check begins
/// when the sensor moves, and ends when the answer is certain.
class SweepTimesValidator {
 public:
  /// A tracker that takes over, because its times are right.
  struct Successor {
    SweepTimesRule times;
    std::unique_ptr<Tracker> tracker;
    TrackedScan tracked;  ///< the scan that was added last, at the same pose as before
  };

  explicit SweepTimesValidator(const FrontEndConfig& config) : config_(config) {}

  /// See Tracker. To be called before the first scan.
  void set_viewpoint_at_origin() { viewpoint_at_origin_ = true; }

  bool is_finished() const { return is_finished_; }
  /// Takes a scan after it was tracked with the times that it was given. What a gyro had corrected
  /// in it has to be put back, and its rate to be left out of the prior.
  std::optional<Successor> add(const Scan& scan, const MotionPrior& prior,
                               const TrackedScan& tracked);
  /// The next scan does not follow the previous one: the check starts again.
  void restart();

 private:
  /// Times that may be right instead of the given ones.
  struct Candidate {
    SweepTimesRule times;
    std::unique_ptr<Tracker> tracker;
    TrackedScan tracked;
    RunningMean gain;  ///< logarithm of how much better its scans fit
  };

  std::unique_ptr<Tracker> new_tracker() const;
  void start(const Scan& scan);
  bool distorts_sweep(Stamp stamp, const Pose& T_odom_base);
  std::vector<Candidate>::iterator best_candidate();
  std::optional<Successor> decide(const TrackedScan& tracked);
  Successor succeed(Candidate& candidate, const TrackedScan& tracked);

  FrontEndConfig config_;
  bool viewpoint_at_origin_ = false;
  bool is_finished_ = false;
  int scans_ = 0;           ///< that were tracked with the candidates
  RecentMedian intervals_;  ///< between the latest scans before the start, s
  double interval_ = 0.0;   ///< their median, s
  std::optional<Pose> last_pose_;
  Stamp last_stamp_ = 0;
  std::vector<Candidate> candidates_;
  /// Tracks the scans with the given times, as the candidates do: in a map as young as theirs, and
  /// without a gyro that corrects the scans, because times look right that are those of a wrong
  /// one.
  std::unique_ptr<Tracker> given_;
};

}  // namespace lidar_mapping::front_end
