// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/ndt_tracker.hpp"

#include <optional>
#include <utility>

#include "judgement/reported_covariance.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Along these directions the rings on the ground contain no information.
const std::vector<Eigen::Vector3d> kLevelDirections = {Eigen::Vector3d::UnitX(),
                                                       Eigen::Vector3d::UnitY()};

}  // namespace

NdtTracker::NdtTracker(const FrontEndConfig& config)
    : max_lost_time_(config.max_lost_time),
      state_(config),
      sweep_(config),
      matcher_(config.registration.neighbor_search),
      judge_(config.max_speed),
      mapper_(config),
      initialization_(config.registration.neighbor_search) {}

TrackedScan NdtTracker::track(const Scan& scan, const MotionPrior& prior) {
  const Step step = sample(scan, prior);
  TrackedScan result = begin_result();
  if (!has_begun_) {
    start(scan, result.status);
  } else if (state_.map.empty()) {
    lose(step, result);
  } else {
    const PredictedMotion predicted = predict(step);
    const StepMatch match = match_scan(step, predicted);
    const StepBelief belief =
        judge_.judge(match, state_, sweep_, state_.lost_time + step.seconds, result.status);
    if (result.status.state == TrackingState::kLost) {
      recover(step, result);
    } else if (!state_.motion_known && initialization_.replaces_first_scan(belief)) {
      replace_first_scan(scan, match, result.status);
    } else {
      update(step, predicted, match, result);
    }
  }
  finish(result);
  return result;
}

NdtTracker::Step NdtTracker::sample(const Scan& scan, const MotionPrior& prior) {
  timer_.start("sampling");
  sweep_.sample(scan, scans_++);
  const double seconds = clock_.advance(scan.stamp, sweep_.reference(), sweep_.duration());
  judge_.advance(seconds);
  return {scan, prior, seconds};
}

/// The elevations are those with which the scan was sampled: the calibration continues with it.
TrackedScan NdtTracker::begin_result() const {
  TrackedScan result;
  result.status.elevation_shift = mapper_.elevation().accepted_angle();
  result.correction.elevation_shift = mapper_.elevation().applied_angle();
  return result;
}

PredictedMotion NdtTracker::predict(const Step& step) {
  timer_.start("matching");
  PredictedMotion predicted =
      predictor_.predict(state_.filter, step.prior, step.seconds, sweep_.duration());
  state_.filter = predicted.filter;
  return predicted;
}

StepMatch NdtTracker::match_scan(const Step& step, const PredictedMotion& predicted) {
  const Prediction& beliefs = predicted.beliefs;
  if (!state_.motion_known) {
    return {initialization_.match_second_scan(sweep_.points(), beliefs.nominal, step.seconds,
                                              matcher_, state_.map),
            beliefs.high_noise};
  }
  std::optional<MotionFilter> recovered = false_standstill_.track(
      sweep_.sparse(), predicted.high_noise_filter, beliefs.nominal.state.T_map_sensor);
  if (recovered) return match_from_vertical_structure(*recovered);
  SweepMatcher::Found found = matcher_.find(sweep_.points(), state_.map, judge_.match_judge(),
                                            beliefs, {state_.last_matched_pose});
  recovered = false_standstill_.detect(sweep_.sparse(), found.match, step.seconds,
                                       state_.coverage.is_single_place, state_.filter);
  if (recovered) return match_from_vertical_structure(*recovered);
  return {match_without_moving_points(std::move(found), beliefs), beliefs.high_noise};
}

/// At a pose that is wrong much lies where free space was.
SweepMatcher::Found NdtTracker::match_without_moving_points(SweepMatcher::Found found,
                                                            const Prediction& beliefs) {
  if (judge_.match_judge().in_doubt(found.match, beliefs.nominal)) return found;
  const PointMarks moving = mapper_.moving_points().find(sweep_.sparse(), found.match.state);
  if (moving.empty()) return found;
  sweep_.leave_out(moving);
  return matcher_.find(sweep_.points(), state_.map, judge_.match_judge(), beliefs,
                       {state_.last_matched_pose});
}

StepMatch NdtTracker::match_from_vertical_structure(const MotionFilter& recovered) {
  state_.filter = recovered;
  initialization_.finalize();
  mapper_.reset_views();
  judge_.reset_usual_quality();
  const MotionBelief prior = recovered.belief();
  StepMatch match{
      matcher_.match_without(sweep_.points(), state_.map, prior, prior.state, kLevelDirections),
      prior};
  match.is_recovered = true;
  return match;
}

void NdtTracker::update(const Step& step, const PredictedMotion& predicted, const StepMatch& match,
                        TrackedScan& result) {
  FrontEndStatus& status = result.status;
  const NdtMatch& ndt = match.found.match;
  if (!state_.motion_known) set_first_motion(ndt);
  if (!status.degenerate_directions.empty() && claims_pose(status.state))
    status.state = TrackingState::kDegenerate;
  learn(step, predicted, match, status);
  correct_motion(match.found, sweep_.duration(), state_);
  predictor_.learn_contradiction(state_.smoother, state_.filter, sweep_.duration());
  if (!claims_pose(status.state))
    state_.covariance += doubt_covariance(ndt.state, match.prior, status.probability);
  update_unobserved_travel(step, predicted, match);
  initialization_.add(step.scan.stamp, sweep_, state_.filter);
  if (status.state != TrackingState::kDegraded)
    update_map(step.scan, match.found.degenerate_directions);
  result.revisions =
      initialization_.rematch_first_scans(state_.filter, judge_.match_judge(), state_.map);
}

void NdtTracker::set_first_motion(const NdtMatch& second) {
  state_.motion_known = true;
  initialization_.set_motion(second);
  false_standstill_.insert(initialization_.first_points(),
                           initialization_.first_state(second.state.twist));
}

void NdtTracker::learn(const Step& step, const PredictedMotion& predicted, const StepMatch& match,
                       const FrontEndStatus& status) {
  const NdtMatch& ndt = match.found.match;
  if (status.degenerate_directions.empty()) {
    predictor_.learn_velocity(step.prior, ndt.state);
  } else {
    mapper_.mark_open_field(ndt.state.T_map_sensor);
  }
  predictor_.learn_rotation(predicted, state_.filter, ndt.state);
  if (status.state != TrackingState::kDegraded) judge_.learn(ndt);
}

void NdtTracker::update_unobserved_travel(const Step& step, const PredictedMotion& predicted,
                                          const StepMatch& match) {
  const std::vector<Eigen::Vector3d>& unobserved = match.found.degenerate_directions;
  if (unobserved.empty() || match.is_recovered) {
    unobserved_travel_.add_observed(match.found.match.state.twist.head<3>().norm(),
                                    velocity_covariance(state_.filter.covariance()).trace(),
                                    step.seconds);
  } else {
    unobserved_travel_.add_unobserved(measured_speed_information(predicted, unobserved),
                                      step.seconds);
  }
}

void NdtTracker::update_map(const Scan& scan,
                            const std::vector<Eigen::Vector3d>& degenerate_directions) {
  if (!mapper_.is_due(state_)) return mapper_.skip(timer_);
  insert(scan);
  state_.filter.anchor(degenerate_directions);
}

void NdtTracker::insert(const Scan& scan) {
  const SampledPoints& dense = mapper_.insert(scan, sweep_, state_, timer_);
  initialization_.set_inserted(dense);
  if (state_.motion_known) false_standstill_.insert(dense, state_.filter.state());
}

void NdtTracker::finish(TrackedScan& result) {
  timer_.start("ageing");
  state_.map.set_center(state_.filter.state().T_map_sensor.translation);
  set_motion_at_stamp(state_, sweep_, result);
  result.provisional = initialization_.is_provisional();
  judge_.finish(result);
  result.status.map_points_dropped = state_.map.dropped_points();
  result.status.unobserved_stddev = unobserved_travel_.stddev();
  result.status.stamp_jitter = clock_.jitter();
  result.status.gyro_distrusted = predictor_.is_gyro_distrusted();
  result.status.velocity_distrusted = predictor_.is_velocity_distrusted();
  result.status.step_seconds = timer_.take();
}

void NdtTracker::set_viewpoint_at_origin() {
  sweep_.set_viewpoint_at_origin();
  mapper_.set_viewpoint_at_origin();
}

}  // namespace lidar_mapping::front_end
