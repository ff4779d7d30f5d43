// SPDX-License-Identifier: BSD-3-Clause
#include "sensor_odometry.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "lidar_mapping/common/cloud_fingerprint.hpp"
#include "lidar_mapping/common/errors.hpp"

#include "judgement/covariance_inflation.hpp"
#include "motion/coasting.hpp"
#include "scan/sweep_times.hpp"

namespace lidar_mapping::front_end {
namespace {

void revise(TrackedScan& tracked, const Revision& revision) {
  tracked.T_odom_base = revision.T_odom_base;
  tracked.covariance = revision.covariance;
  tracked.drift_variance_factor = revision.drift_variance_factor;
  tracked.twist = revision.twist;
  tracked.acceleration = revision.acceleration;
  tracked.status.degenerate_directions = revision.degenerate_directions;
  tracked.motion_known = true;
}

MotionPrior without_rate(MotionPrior prior) {
  prior.angular_velocity.reset();
  return prior;
}

/// Moves the times of all steps to the status.
void report_times(StepTimer& timer, FrontEndStatus& status) {
  for (auto& step : timer.take()) status.step_seconds.push_back(std::move(step));
  for (const auto& step : status.step_seconds) status.seconds += step.second;
}

}  // namespace

SensorOdometry::SensorOdometry(const FrontEndConfig& config)
    : matches_scans_(config.odometry == OdometrySource::kLidar),
      tracker_(make_tracker(config)),
      key_frames_(config) {
  if (config.check_point_times && is_sequential_ndt(config)) times_validator_.emplace(config);
}

Eigen::Vector3d SensorOdometry::angular_velocity() const {
  return tracked_ ? Eigen::Vector3d(tracked_->twist.tail<3>()) : Eigen::Vector3d::Zero();
}

FrontEndResult SensorOdometry::process(const Scan& received, const MotionPrior& prior) {
  check_stamp(received.stamp);
  if (matches_scans_ && is_repeated(received.cloud, prior) && tracked_)
    return coast(received.stamp);
  timer_.start("isolated points");
  const PointCorrection correction = correction_of(prior);
  const std::optional<Scan> changed = changed_scan(received, prior, correction);
  const Scan& timed = changed ? *changed : received;
  const Scan& scan = matches_scans_ ? isolated_point_filter_.without_isolated_points(timed) : timed;
  timer_.stop();
  TrackedScan tracked = tracker_->track(scan, with_valid_rate(prior));
  state_times(correction, tracked);
  std::vector<FrontEndResult> finalized;
  const bool times_change = try_other_times(scan, prior, tracked, finalized);
  check_vertical_ride(scan.stamp, prior, tracked);
  tracked_ = tracked;
  last_stamp_ = tracked_stamp_ = scan.stamp;
  timer_.start("key frame");
  if (!times_change && (tracked.new_segment || !tracked.provisional))
    finalized = finalize_provisional(tracked.revisions);
  if (tracked.new_segment) start_segment();
  FrontEndResult result = result_of(scan.stamp, tracked);
  result.finalized = std::move(finalized);
  if (tracked.provisional) {
    result.provisional = true;
    provisional_.push_back({result, tracked, key_frames_.points_of(scan.cloud, tracked)});
  } else if (!times_change && key_frames_.is_due(scan.stamp, scan.cloud.has_times(), tracked)) {
    result.key_frame = key_frames_.make(scan.stamp, segment_, tracked,
                                        key_frames_.points_of(scan.cloud, tracked), *tracker_);
  }
  report_times(timer_, result.status);
  return result;
}

std::vector<FrontEndResult> SensorOdometry::finalize() {
  tracker_->finalize();
  return finalize_provisional({});
}

void SensorOdometry::resume(KeyFrameIndex next_index, std::uint32_t next_segment) {
  segment_ = next_segment;
  key_frames_.resume(next_index);
  last_.reset();
  tracked_.reset();
  last_fingerprint_.reset();
  ride_detector_.interrupt();
  provisional_.clear();
  tracker_->restart();
  if (times_validator_) times_validator_->restart();
}

void SensorOdometry::set_viewpoint_at_origin() {
  tracker_->set_viewpoint_at_origin();
  if (times_validator_) times_validator_->set_viewpoint_at_origin();
}

void SensorOdometry::check_stamp(Stamp stamp) const {
  if (!last_stamp_ || stamp > *last_stamp_) return;
  throw InputError("front_end: stamp " + std::to_string(stamp) + " ns does not come after " +
                   std::to_string(*last_stamp_) + " ns; drop scans that are out of order");
}

/// True if a driver that hangs delivers the points of the previous scan again under a new stamp.
bool SensorOdometry::is_repeated(const PointCloud& cloud, const MotionPrior& prior) {
  const auto fingerprint = prior.fingerprint ? prior.fingerprint : cloud_fingerprint(cloud);
  const auto last = std::exchange(last_fingerprint_, fingerprint);
  return fingerprint && fingerprint == last;
}

/// A repeated scan is not matched: it would fit at the last pose.
FrontEndResult SensorOdometry::coast(Stamp stamp) {
  std::vector<FrontEndResult> finalized = finalize();
  ride_detector_.interrupt();
  last_stamp_ = stamp;
  FrontEndResult result = result_of(stamp, coasted(*tracked_, to_seconds(stamp - tracked_stamp_)));
  result.finalized = std::move(finalized);
  return result;
}

/// Times and gyro as they are judged now; the tracker knows the elevations.
PointCorrection SensorOdometry::correction_of(const MotionPrior& prior) const {
  PointCorrection correction;
  correction.times = times_;
  correction.undo_gyro = prior.uneven_turning &&
                         (times_.source != SweepTimes::kAsGiven || !tracker_->accepts_gyro(prior));
  return correction;
}

/// Empty if nothing changes.
std::optional<Scan> SensorOdometry::changed_scan(const Scan& scan, const MotionPrior& prior,
                                                 const PointCorrection& correction) {
  if (!correction.undo_gyro && correction.times.source == SweepTimes::kAsGiven) return std::nullopt;
  return Scan{scan.stamp, with_right_times(scan.cloud, prior.uneven_turning, correction)};
}

/// The elevations stay those by which the tracker has sampled the scan.
void SensorOdometry::state_times(const PointCorrection& correction, TrackedScan& tracked) {
  tracked.correction.undo_gyro = correction.undo_gyro;
  tracked.correction.times = tracked.status.sweep_times = correction.times;
}

/// The rate is the mean of the sweep by its given times, or, without these, the rate at the stamp.
/// By other times the sweep has another mean.
MotionPrior SensorOdometry::with_valid_rate(const MotionPrior& prior) const {
  return times_.source == SweepTimes::kAsGiven ? prior : without_rate(prior);
}

/// Continues the check of the times, if it is not finished. If other times are right, their
/// tracker takes over, and the function returns true; the scan itself still has the wrong times.
bool SensorOdometry::try_other_times(const Scan& scan, const MotionPrior& prior,
                                     TrackedScan& tracked, std::vector<FrontEndResult>& finalized) {
  if (!times_validator_) return false;
  timer_.start("point times");
  std::optional<Scan> uncorrected;
  if (prior.uneven_turning && !tracked.correction.undo_gyro)
    uncorrected = Scan{scan.stamp, put_back(*prior.uneven_turning, scan.cloud)};
  std::optional<SweepTimesValidator::Successor> successor =
      times_validator_->add(uncorrected ? *uncorrected : scan, without_rate(prior), tracked);
  if (times_validator_->is_finished()) times_validator_.reset();
  timer_.stop();
  if (!successor) return false;
  finalized = finalize();
  tracker_ = std::move(successor->tracker);
  times_ = successor->times;
  tracked = std::move(successor->tracked);
  state_times(correction_of(prior), tracked);
  return true;
}

/// During a vertical ride that the points do not show, the vertical direction is unobserved, like
/// the axis of a tunnel.
void SensorOdometry::check_vertical_ride(Stamp stamp, const MotionPrior& prior,
                                         TrackedScan& tracked) {
  FrontEndStatus& status = tracked.status;
  const bool is_connected =
      last_stamp_ && !tracked.new_segment && status.state != TrackingState::kLost;
  if (!is_connected) ride_detector_.interrupt();
  const double seconds = last_stamp_ ? to_seconds(stamp - *last_stamp_) : 0.0;
  const bool adjoins = prior.felt && last_stamp_ == prior.felt->since;
  ride_detector_.add(tracked.T_odom_base, seconds, adjoins ? prior.felt : std::nullopt);
  status.vertical_ride_distance = ride_detector_.distance();
  status.unobserved_stddev = std::hypot(status.unobserved_stddev, ride_detector_.distance());
  if (!ride_detector_.is_riding()) return;
  status.degenerate_directions.push_back(tracked.T_odom_base.rotation.conjugate() *
                                         ride_detector_.up());
  if (claims_pose(status.state)) status.state = TrackingState::kDegenerate;
}

FrontEndResult SensorOdometry::result_of(Stamp stamp, const TrackedScan& tracked) {
  FrontEndResult result;
  result.stamp = stamp;
  result.segment = segment_;
  result.T_odom_base = tracked.T_odom_base;
  result.twist = tracked.twist;
  result.acceleration = tracked.acceleration;
  result.correction = tracked.correction;
  result.status = tracked.status;
  if (last_) result.covariance = add_step(*last_, tracked);
  last_ = tracked;
  return result;
}

/// Returns the covariance of the step.
Covariance6 SensorOdometry::add_step(const TrackedScan& from, const TrackedScan& to) {
  key_frames_.add_step(from, to);
  Covariance6 covariance = tracker_->covariance_of_step(from, to);
  if (!is_doubtful(to.status)) return covariance;
  return covariance + expected_error_covariance(to.status);
}

void SensorOdometry::start_segment() {
  ++segment_;
  last_.reset();
  key_frames_.start_segment();
}

std::vector<FrontEndResult> SensorOdometry::finalize_provisional(
    const std::vector<Revision>& revisions) {
  std::vector<FrontEndResult> finalized;
  if (!provisional_.empty()) {
    // The steps of these scans are added again.
    last_.reset();
    key_frames_.reset_steps();
  }
  for (std::size_t i = 0; i < provisional_.size(); ++i) {
    if (i < revisions.size()) revise(provisional_[i].tracked, revisions[i]);
    finalized.push_back(finalized_scan(std::move(provisional_[i])));
  }
  provisional_.clear();
  return finalized;
}

FrontEndResult SensorOdometry::finalized_scan(ProvisionalScan provisional) {
  const TrackedScan& tracked = provisional.tracked;
  FrontEndResult result = result_of(provisional.result.stamp, tracked);
  result.status.step_seconds = provisional.result.status.step_seconds;
  result.status.seconds = provisional.result.status.seconds;
  if (key_frames_.is_due(result.stamp, provisional.points.has_times(), tracked)) {
    result.key_frame =
        key_frames_.make(result.stamp, segment_, tracked, std::move(provisional.points), *tracker_);
  }
  return result;
}

}  // namespace lidar_mapping::front_end
