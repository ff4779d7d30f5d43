// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/sweep_times_validator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"

#include "motion/motion_filter.hpp"
#include "scan/sweep_order.hpp"
#include "scan/sweep_times.hpp"

namespace lidar_mapping::front_end {
namespace {

/// The times of the points matter if the motion within a sweep moves a point at this distance (m;
/// chosen as of the surfaces of rooms and streets) by at least this length (m; chosen: several
/// times the noise).
constexpr double kTypicalRange = 10.0;
constexpr double kMinMotion = 0.1;
/// Scans after the start of the maps that are not compared. Chosen: a map of so many scans covers
/// the view.
constexpr int kSettlingScans = 4;
/// Nothing is decided with fewer scans; chosen so that no single object decides.
constexpr int kMinScans = 8;
/// After so many scans the check ends and the given times are kept. Chosen: 15 s at 10 Hz, as it
/// doubles the computing time.
constexpr int kMaxScans = 150;
/// A gain decides if it exceeds this limit by so many of its standard deviations. Measured: wrong
/// times raised the variance of the residuals by 17 to 57 % in simulated drives on streets and on
/// foot. Chosen far below; and so many standard deviations, because successive scans err alike.
constexpr double kMinGain = 0.05;
constexpr double kMinSigmas = 6.0;
/// Gain if only one of two trackers has a match. Chosen above those of two matches (0.45 at most).
constexpr double kGainOfMatch = 1.0;
/// Variance of the residuals that is too small to be compared (in units of what planes claim).
/// Chosen: simulated scans without noise have less.
constexpr double kLeastVariance = 0.01;
/// Time between scans above which some scans are missing, s; chosen above the slowest usual rate (5
/// Hz). Then a sweep lasts as long as by the default of most sensors (10 Hz).
constexpr double kMaxDuration = 0.25;
constexpr double kUsualDuration = 0.1;
/// Time between scans from which some scans may be missing, s. Chosen between the usual rates (10
/// and 5 Hz).
constexpr double kDoubtfulDuration = 0.15;

/// So many intervals tell the time between scans. Chosen: a sensor may stand for days before it
/// moves, and half of them may be missing scans.
constexpr std::size_t kIntervals = 64;

/// How long a sweep may last (s), given the time between scans.
std::vector<double> durations_for(double interval) {
  if (interval > kMaxDuration) return {kUsualDuration};
  if (interval > kDoubtfulDuration) return {interval, kUsualDuration};
  return {interval};
}

constexpr bool kClockwise = true, kCounterclockwise = false;  // by definition of SensorRotation
/// Sweeps begin ahead or behind. Facts of the sensors: Velodyne's driver begins at the azimuth 0,
/// KITTI's files at 180 degrees, both clockwise; Ouster's begins behind, Hesai's ahead.
constexpr std::array<SensorRotation, 4> kRotations = {
    {{kClockwise, 0.0}, {kClockwise, kPi}, {kCounterclockwise, 0.0}, {kCounterclockwise, kPi}}};

/// Rules for points without times, which may be stored firing by firing or in any other order.
std::vector<SweepTimesRule> rules_without_times(const PointCloud& cloud, double duration) {
  std::vector<SweepTimesRule> rules = {{SweepTimes::kByAzimuth, duration, std::nullopt}};
  if (!in_sweep_order(cloud)) {
    for (const SensorRotation& rotation : kRotations)
      rules.push_back({SweepTimes::kByAzimuth, duration, rotation});
  }
  rules.push_back({SweepTimes::kByPosition, duration, std::nullopt});
  return rules;
}

std::vector<SweepTimesRule> candidates_for(const PointCloud& cloud, double interval) {
  if (cloud.has_times()) return {{SweepTimes::kNegated, 0.0, std::nullopt}};
  std::vector<SweepTimesRule> rules;
  for (const double duration : durations_for(interval)) {
    const std::vector<SweepTimesRule> more = rules_without_times(cloud, duration);
    rules.insert(rules.end(), more.begin(), more.end());
  }
  return rules;
}

/// Logarithm of the ratio of the residuals' variances. Empty if neither has a match.
std::optional<double> gain_of(const FrontEndStatus& candidate, const FrontEndStatus& given) {
  const bool has_candidate = claims_pose(candidate.state);
  const bool has_given = claims_pose(given.state);
  if (has_candidate && has_given) {
    return std::log((given.evidence.residual_variance + kLeastVariance) /
                    (candidate.evidence.residual_variance + kLeastVariance));
  }
  if (!has_candidate && !has_given) return std::nullopt;
  return has_candidate ? kGainOfMatch : -kGainOfMatch;
}

/// How certain it is that the gain is positive, or negative: 0 if it may be small.
double certainty(const RunningMean& gain) {
  if (gain.count() < kMinScans) return 0.0;
  const double beyond = std::abs(gain.mean()) - kMinGain - kMinSigmas * gain.sigma();
  return beyond > 0.0 ? std::copysign(beyond, gain.mean()) : 0.0;
}

/// A tracker whose first pose is another one than the origin.
class MovedTracker : public Tracker {
 public:
  /// `T_odom_start` is the frame of the given tracker.
  MovedTracker(std::unique_ptr<Tracker> tracker, const Pose& T_odom_start)
      : tracker_(std::move(tracker)), T_odom_start_(T_odom_start) {}

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override {
    return moved(tracker_->track(scan, prior));
  }
  Covariance6 covariance_of_step(const TrackedScan& from, const TrackedScan& to) const override {
    return tracker_->covariance_of_step(from, to);
  }
  bool accepts_gyro(const MotionPrior& prior) const override {
    return tracker_->accepts_gyro(prior);
  }
  void set_viewpoint_at_origin() override { tracker_->set_viewpoint_at_origin(); }
  void restart() override {
    T_odom_start_ = Pose::Identity();
    tracker_->restart();
  }
  void finalize() override { tracker_->finalize(); }
  PointCloud local_map() const override {
    return transformed(tracker_->local_map(), T_odom_start_);
  }

  /// A result of the given tracker, as one of this tracker.
  TrackedScan moved(TrackedScan tracked) const {
    tracked.T_odom_base = T_odom_start_ * tracked.T_odom_base;
    for (Revision& revision : tracked.revisions)
      revision.T_odom_base = T_odom_start_ * revision.T_odom_base;
    return tracked;
  }

 private:
  std::unique_ptr<Tracker> tracker_;
  Pose T_odom_start_;
};

}  // namespace

void RunningMean::add(double value) {
  ++count_;
  const double before = value - mean_;
  mean_ += before / count_;
  squares_ += before * (value - mean_);
}

double RunningMean::sigma() const {
  if (count_ < 2) return std::numeric_limits<double>::infinity();
  return std::sqrt(squares_ / (count_ - 1) / count_);
}

void RecentMedian::add(double value) {
  values_.push_back(value);
  if (values_.size() > kIntervals) values_.pop_front();
}

double RecentMedian::median() const {
  return lidar_mapping::median(std::vector<double>(values_.begin(), values_.end()));
}

void SweepTimesValidator::restart() {
  candidates_.clear();
  given_.reset();
  last_pose_.reset();
  intervals_.clear();
  scans_ = 0;
}

std::unique_ptr<Tracker> SweepTimesValidator::new_tracker() const {
  std::unique_ptr<Tracker> tracker = make_tracker(config_);
  if (viewpoint_at_origin_) tracker->set_viewpoint_at_origin();
  return tracker;
}

void SweepTimesValidator::start(const Scan& scan) {
  given_ = new_tracker();
  for (const SweepTimesRule& rule : candidates_for(scan.cloud, interval_))
    candidates_.push_back({rule, new_tracker(), {}, {}});
}

/// True if the motion since the previous scan distorts a sweep.
bool SweepTimesValidator::distorts_sweep(Stamp stamp, const Pose& T_odom_base) {
  const double seconds = to_seconds(stamp - std::exchange(last_stamp_, stamp));
  const std::optional<Pose> previous = std::exchange(last_pose_, T_odom_base);
  if (!previous) return false;
  if (candidates_.empty()) {
    intervals_.add(seconds);
    interval_ = intervals_.median();
  }
  const Vector6d twist = twist_between(*previous, T_odom_base, seconds);
  return durations_for(interval_).back() *
             (twist.head<3>().norm() + kTypicalRange * twist.tail<3>().norm()) >=
         kMinMotion;
}

std::optional<SweepTimesValidator::Successor> SweepTimesValidator::add(const Scan& scan,
                                                                       const MotionPrior& prior,
                                                                       const TrackedScan& tracked) {
  if (tracked.new_segment) restart();
  const bool moves = distorts_sweep(scan.stamp, tracked.T_odom_base);
  if (candidates_.empty()) {
    if (!moves) return std::nullopt;
    start(scan);
  }
  ++scans_;
  const FrontEndStatus given = given_->track(scan, prior).status;
  for (Candidate& candidate : candidates_) {
    const Scan retimed = {scan.stamp,
                          {scan.cloud.points, sweep_times(scan.cloud, candidate.times)}};
    candidate.tracked = candidate.tracker->track(retimed, prior);
    if (!moves || scans_ <= kSettlingScans) continue;
    if (const auto gain = gain_of(candidate.tracked.status, given)) candidate.gain.add(*gain);
  }
  return decide(tracked);
}

/// The candidate whose scans fit best. One from another source than an earlier one has to be better
/// by the least gain.
std::vector<SweepTimesValidator::Candidate>::iterator SweepTimesValidator::best_candidate() {
  auto best = candidates_.begin();
  for (auto candidate = best; candidate != candidates_.end(); ++candidate) {
    const double margin = candidate->times.source == best->times.source ? 0.0 : kMinGain;
    if (candidate->gain.mean() > best->gain.mean() + margin) best = candidate;
  }
  return best;
}

/// The best candidate succeeds as soon as its gain is certain. Candidates whose loss is certain are
/// left out; the given times stay when none remains.
std::optional<SweepTimesValidator::Successor> SweepTimesValidator::decide(
    const TrackedScan& tracked) {
  const auto has_lost = [](const Candidate& candidate) { return certainty(candidate.gain) < 0.0; };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), has_lost),
                    candidates_.end());
  std::optional<Successor> successor;
  is_finished_ = scans_ >= kMaxScans || candidates_.empty();
  const auto best = best_candidate();
  if (best != candidates_.end() && certainty(best->gain) > 0.0 &&
      claims_pose(best->tracked.status.state)) {
    successor = succeed(*best, tracked);
    is_finished_ = true;
  }
  if (is_finished_) restart();
  return successor;
}

/// The candidate's tracker goes on from the pose of the scan that was tracked last.
SweepTimesValidator::Successor SweepTimesValidator::succeed(Candidate& candidate,
                                                            const TrackedScan& tracked) {
  candidate.tracker->finalize();
  const Pose T_odom_start = tracked.T_odom_base * candidate.tracked.T_odom_base.inverse();
  auto moved = std::make_unique<MovedTracker>(std::move(candidate.tracker), T_odom_start);
  TrackedScan result = moved->moved(candidate.tracked);
  result.provisional = false;
  result.revisions.clear();
  return {candidate.times, std::move(moved), std::move(result)};
}

}  // namespace lidar_mapping::front_end
