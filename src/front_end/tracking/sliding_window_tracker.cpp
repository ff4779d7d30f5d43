// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/sliding_window_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/front_end/deskew.hpp"

#include "matching/degeneracy.hpp"
#include "matching/search_starts.hpp"
#include "motion/motion_filter.hpp"

namespace lidar_mapping::front_end {

namespace {

using registration::RegistrationResult;

// Fractions of the scan that must lie on the map. Chosen: at a wrong pose little but the road fits,
// and of a new view half may not be in the map.
constexpr double kTrackedInliers = 0.35;
constexpr double kLostInliers = 0.2;
// If the speed is not known, starting poses are tried up to this speed (126 km/h), in steps of this
// length. Chosen: faster than most drives begin, and within the convergence basin of NDT (2 m).
constexpr double kMaxStartSpeed = 35.0;  // m/s
constexpr double kStartStep = 1.0;       // m
// Weight of the last step in the twist that deskews a sweep. An error of the pose bends the sweep,
// and a bent sweep rotates the pose. Tried: with 1 the two errors amplify each other.
constexpr double kSweepSmoothing = 0.4;
// Standard deviations of a pose that was predicted, not measured. Chosen wide, so that loops
// decide.
constexpr double kLostSigma = 1.0;       // m
constexpr double kLostAngleSigma = 0.1;  // rad

/// Variance of a speed between two matches, and of a measured speed. Chosen: (0.1 m/s)^2, a
/// centimetre of error per scan at 10 Hz.
constexpr double kSpeedVariance = 0.01;  // m^2/s^2

/// The matched pose, but with the predicted position along directions that the match did not
/// observe.
Pose with_prediction_along(const Pose& predicted, const Pose& matched,
                           const std::vector<Eigen::Vector3d>& directions) {
  Vector6d correction = difference(matched, predicted);
  Vector6d predicted_part = Vector6d::Zero();
  for (const Eigen::Vector3d& direction : directions) {
    predicted_part.head<3>() += direction * direction.dot(correction.head<3>());
  }
  return perturbed(matched, predicted_part);
}

Covariance6 covariance_of(const Matrix6d& hessian) {
  // A weak prior keeps the covariance finite along directions that were not observed.
  const Matrix6d prior = diagonal_covariance(kLostSigma, kLostAngleSigma).inverse();
  return (hessian + prior).inverse();
}

}  // namespace

SlidingWindowTracker::SlidingWindowTracker(const FrontEndConfig& config)
    : config_(config),
      rule_{config.key_frame_distance, config.key_frame_angle, 0.0},
      registration_(registration::make_registration(config.registration)),
      window_(static_cast<std::size_t>(config.local_frame_num),
              config.local_map_filter_resolution) {}

TrackedScan SlidingWindowTracker::track(const Scan& scan, const MotionPrior& prior) {
  if (window_.empty()) return start(scan, prior);
  timer_.start("sampling");
  const double seconds = to_seconds(scan.stamp - stamp_);
  step_origin_.advance(seconds);
  predict_twist(prior);
  const Pose predicted = continued(T_odom_base_, twist_, seconds);
  const PointCloud cloud = deskewed(scan.cloud, sweep_twist_);
  const PointCloud sample = voxel_filtered(cloud, config_.frame_filter_resolution);
  timer_.start("matching");
  const Match match = match_scan(sample, predicted, seconds);
  TrackedScan tracked = evaluate(match, predicted, seconds);
  judge(match, predicted, seconds, sample.size(), tracked.status);
  set_pose(tracked, scan.stamp, prior.linear_velocity.has_value());
  timer_.start("insertion");
  update_window(cloud, tracked);
  step_origin_.update(tracked);
  tracked.twist = twist_;
  tracked.motion_known = speed_known_;
  tracked.status.step_seconds = timer_.take();
  return tracked;
}

TrackedScan SlidingWindowTracker::start(const Scan& scan, const MotionPrior& prior) {
  doubt_.reset();
  predict_twist(prior);
  speed_known_ = prior.linear_velocity.has_value();
  stamp_ = tracked_stamp_ = scan.stamp;
  insert_key_frame(deskewed(scan.cloud, sweep_twist_));
  TrackedScan tracked;
  tracked.T_odom_base = T_odom_base_;
  tracked.covariance = diagonal_covariance(1e-4, 1e-5);
  tracked.twist = twist_;
  tracked.motion_known = speed_known_;
  tracked.status.converged = true;
  tracked.status.inlier_fraction = tracked.status.overlap = 1.0;
  step_origin_.update(tracked);
  return tracked;
}

void SlidingWindowTracker::judge(const Match& match, const Pose& predicted, double seconds,
                                 std::size_t points, FrontEndStatus& status) {
  status.evidence = collect_evidence(match, predicted, seconds);
  status.evidence.points = static_cast<double>(points);
  status.evidence.degenerate = status.degenerate_directions.empty() ? 0.0 : 1.0;
  doubt_.apply(evaluate_step(status.evidence, EvidenceSource::kSlidingWindow), status);
}

/// Evidence for and against the match as the end of a step from the last claimed pose.
StepEvidence SlidingWindowTracker::collect_evidence(const Match& match, const Pose& predicted,
                                                    double seconds) const {
  const RegistrationResult& result = match.result;
  StepEvidence evidence;
  evidence.overlap = result.overlap;
  evidence.pair_quality = result.overlap > 0.0 ? result.inlier_fraction / result.overlap : 0.0;
  evidence.converged = result.converged ? 1.0 : 0.0;
  evidence.iterations = result.iterations;
  evidence.rescued = match.rescued ? 1.0 : 0.0;
  const Vector6d d = difference(predicted, result.T_target_source);
  evidence.surprise = d.head<3>().norm();
  evidence.surprise_angle = d.tail<3>().norm();
  // Half of the squared time, for the displacement by the largest acceleration.
  const double reach = 0.5 * seconds * seconds;
  evidence.surprise_sigmas =
      std::hypot(evidence.surprise / (reach * config_.acceleration_sigma),
                 evidence.surprise_angle / (reach * config_.angular_acceleration_sigma));
  step_origin_.set_step_to({result.T_target_source, covariance_of(result.hessian), 1.0}, evidence);
  return evidence;
}

void SlidingWindowTracker::predict_twist(const MotionPrior& prior) {
  sweep_twist_ += kSweepSmoothing * (twist_ - sweep_twist_);
  if (prior.linear_velocity) {
    twist_.head<3>() = sweep_twist_.head<3>() = *prior.linear_velocity;
  }
  if (prior.angular_velocity) {
    twist_.tail<3>() = sweep_twist_.tail<3>() = *prior.angular_velocity;
  }
}

SlidingWindowTracker::Match SlidingWindowTracker::match_from(const Pose& T_odom_base_start,
                                                             const PointCloud& sample) {
  const Pose& T_odom_target = window_.newest_pose();
  Match match;
  match.result = registration_->align(sample, T_odom_target.inverse() * T_odom_base_start);
  match.result.T_target_source = T_odom_target * match.result.T_target_source;
  return match;
}

SlidingWindowTracker::Match SlidingWindowTracker::match_scan(const PointCloud& sample,
                                                             const Pose& predicted,
                                                             double seconds) {
  Match best = match_from(predicted, sample);
  if (speed_known_ && best.result.inlier_fraction >= kLostInliers) return best;
  for (const Pose& start : other_starts(seconds)) {
    Match other = match_from(start, sample);
    if (other.result.inlier_fraction > best.result.inlier_fraction) {
      best = std::move(other);
      best.rescued = true;
    }
  }
  return best;
}

/// The pose at rest and, if the speed is not known, poses ahead.
std::vector<Pose> SlidingWindowTracker::other_starts(double seconds) const {
  std::vector<Pose> starts = {T_odom_base_};
  if (speed_known_) return starts;
  const double farthest = kMaxStartSpeed * std::min(seconds, kLongestSearchedTime);
  for (double distance = kStartStep; distance < farthest; distance += kStartStep) {
    starts.push_back(T_odom_base_ * Pose{Eigen::Quaterniond::Identity(), {distance, 0.0, 0.0}});
  }
  return starts;
}

TrackedScan SlidingWindowTracker::evaluate(const Match& match, const Pose& predicted,
                                           double seconds) const {
  const RegistrationResult& result = match.result;
  TrackedScan tracked;
  tracked.status.converged = result.converged;
  tracked.status.iterations = result.iterations;
  tracked.status.fitness = result.fitness;
  tracked.status.inlier_fraction = result.inlier_fraction;
  tracked.status.overlap = result.overlap;
  tracked.status.rescued = match.rescued;
  const double distance = (result.T_target_source.translation - T_odom_base_.translation).norm();
  if (result.inlier_fraction < kLostInliers || distance > config_.max_speed * seconds) {
    tracked.status.state = TrackingState::kLost;
    tracked.T_odom_base = predicted;
    tracked.covariance = diagonal_covariance(kLostSigma, kLostAngleSigma);
    return tracked;
  }
  tracked.status.degenerate_directions = degenerate_directions(result.hessian);
  tracked.T_odom_base = with_prediction_along(predicted, result.T_target_source,
                                              tracked.status.degenerate_directions);
  tracked.covariance = covariance_of(result.hessian);
  if (result.inlier_fraction < kTrackedInliers) {
    tracked.status.state = TrackingState::kDegraded;
  } else if (!tracked.status.degenerate_directions.empty()) {
    tracked.status.state = TrackingState::kDegenerate;
  }
  return tracked;
}

/// Adopts the pose; the velocity is computed only from poses that were measured.
void SlidingWindowTracker::set_pose(TrackedScan& tracked, Stamp stamp, bool speed_is_measured) {
  if (tracked.status.state == TrackingState::kLost) {
    unobserved_travel_.interrupt();
  } else {
    twist_ = twist_between(T_odom_base_, tracked.T_odom_base, to_seconds(stamp - stamp_));
    speed_known_ = true;
    tracked_stamp_ = stamp;
    update_unobserved_travel(tracked.status, to_seconds(stamp - stamp_), speed_is_measured);
  }
  tracked.status.unobserved_stddev = unobserved_travel_.stddev();
  T_odom_base_ = tracked.T_odom_base;
  stamp_ = stamp;
}

void SlidingWindowTracker::update_unobserved_travel(const FrontEndStatus& status, double seconds,
                                                    bool speed_is_measured) {
  if (status.degenerate_directions.empty()) {
    unobserved_travel_.add_observed(twist_.head<3>().norm(), kSpeedVariance, seconds);
  } else {
    unobserved_travel_.add_unobserved(speed_is_measured ? 1.0 / kSpeedVariance : 0.0, seconds);
  }
}

/// Discards the window if tracking has been lost for too long.
void SlidingWindowTracker::update_window(const PointCloud& cloud, TrackedScan& tracked) {
  if (to_seconds(stamp_ - tracked_stamp_) > config_.max_lost_time) {
    window_.clear();
    tracked.new_segment = true;
  }
  if (key_frame_due(tracked)) insert_key_frame(cloud);
}

bool SlidingWindowTracker::key_frame_due(const TrackedScan& tracked) const {
  if (window_.empty()) return true;
  if (tracked.status.state == TrackingState::kLost ||
      tracked.status.state == TrackingState::kDegraded) {
    return false;
  }
  return rule_.motion_reached(window_.newest_pose().inverse() * tracked.T_odom_base);
}

/// The target is relative to the newest key frame, so that single precision is sufficient far from
/// the start.
void SlidingWindowTracker::insert_key_frame(PointCloud cloud) {
  tracked_stamp_ = stamp_;
  window_.push(T_odom_base_, std::move(cloud));
  registration_->set_target(window_.joint_cloud(T_odom_base_.inverse()));
}

void SlidingWindowTracker::restart() {
  window_.clear();
  T_odom_base_ = Pose::Identity();
  twist_.setZero();
  sweep_twist_.setZero();
}

}  // namespace lidar_mapping::front_end
