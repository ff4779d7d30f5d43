// SPDX-License-Identifier: BSD-3-Clause
#include "start/delayed_initialization.hpp"

#include <utility>

#include "matching/degeneracy.hpp"

namespace lidar_mapping::front_end {

namespace {

/// In a map of half this number of scans, the planes of a sensor with few rings are upright.
/// Measured on 37 simulated starts at speed (16 beams): the mean drift falls from 0.097 to 0.056 %.
constexpr std::size_t kWantedInsertions = 24;
/// Time limit for a slow vehicle, s. Chosen: key frames must not wait longer.
constexpr double kMaxDuration = 6.0;
/// With fewer scans the map cannot be improved. Chosen: half of them make a map of three scans, as
/// many as are always inserted (kInitialScans of local_mapper.cpp).
constexpr std::size_t kMinInsertions = 6;
/// Number of scans that are matched again per new scan. Measured: the slowest scan of a start takes
/// 12 times the median, and 32 times if all are matched at once.
constexpr std::size_t kScansPerCall = 4;

double seconds_between(const MatchedScan& from, const MatchedScan& to) {
  return to_seconds(to.stamp - from.stamp) + to.reference - from.reference;
}

void insert(const MatchedScan& scan, const MotionState& state, LocalMap& map) {
  if (scan.dense.size() > 0) map.insert(scan.dense, state);
}

}  // namespace

void DelayedInitialization::start() {
  stop();
  active_ = true;
}

void DelayedInitialization::stop() {
  active_ = false;
  inserted_scans_ = 0;
  scans_.clear();
  filter_.reset();
  remaining_ = 0;
  results_.clear();
}

void DelayedInitialization::add(MatchedScan scan) {
  if (active_ && !filter_) scans_.push_back(std::move(scan));
}

void DelayedInitialization::set_inserted(const SampledPoints& dense) {
  if (!active_ || filter_) return;
  scans_.back().dense = dense;
  ++inserted_scans_;
}

void DelayedInitialization::set_first_state(const MotionState& state) {
  scans_.front().state = state;
}

bool DelayedInitialization::is_complete() const {
  return inserted_scans_ >= kWantedInsertions ||
         to_seconds(scans_.back().stamp - scans_.front().stamp) > kMaxDuration;
}

std::size_t DelayedInitialization::first_of_later_half() const {
  std::size_t earlier_insertions = 0;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    if (scans_[i].dense.size() > 0 && earlier_insertions++ == inserted_scans_ / 2) return i;
  }
  return 0;
}

void DelayedInitialization::start_rematching(const MotionFilter& filter, LocalMap& map) {
  filter_ = filter;
  if (inserted_scans_ < kMinInsertions) return;
  remaining_ = first_of_later_half();
  results_.resize(remaining_);
  map.clear();
  for (std::size_t i = remaining_; i < scans_.size(); ++i) insert(scans_[i], scans_[i].state, map);
  filter_->restart(scans_[remaining_].state, scans_[remaining_].covariance);
}

bool DelayedInitialization::rematch_scan(std::size_t i, const MatchJudge& judge, LocalMap& map) {
  const MatchedScan& scan = scans_[i];
  const double seconds = seconds_between(scans_[i + 1], scan);
  MotionFilter high_noise = filter_->with_high_process_noise();
  high_noise.predict(seconds);
  filter_->predict(seconds);
  const MotionBelief belief = filter_->belief();
  const Prediction prediction{belief, belief, high_noise.belief()};
  results_[i] = matcher_.find(scan.points, map, judge, prediction, {});
  const NdtMatch& match = results_[i].match;
  if (judge.judge(match, prediction.high_noise) == TrackingState::kLost) return false;
  filter_->correct(match.state, match.information.inverse(),
                   projection_orthogonal_to(results_[i].degenerate_directions));
  insert(scan, match.state, map);
  return true;
}

bool DelayedInitialization::rematch(const MotionFilter& filter, const MatchJudge& judge,
                                    LocalMap& map) {
  if (!filter_) {
    if (!is_complete()) return false;
    start_rematching(filter, map);
    return remaining_ == 0;
  }
  for (std::size_t k = 0; k < kScansPerCall && remaining_ > 0; ++k) {
    if (rematch_scan(--remaining_, judge, map)) continue;
    remaining_ = 0;
    results_.clear();
  }
  return remaining_ == 0;
}

}  // namespace lidar_mapping::front_end
