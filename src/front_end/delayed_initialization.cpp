// SPDX-License-Identifier: BSD-3-Clause
#include "delayed_initialization.hpp"

#include <utility>

#include "degeneracy.hpp"

namespace lidar_mapping::front_end {

namespace {

/// In half of so many scans the planes of few rings stand upright.
constexpr std::size_t kInsertedScans = 24;
/// A slow vehicle does not get so far: key frames are not to wait longer, s.
constexpr double kLongest = 6.0;
/// Of fewer nothing better can be made.
constexpr std::size_t kFewestInserted = 6;
/// So many are matched again per scan that comes in: all at once would hold that one up.
constexpr std::size_t kAtOnce = 4;

double seconds_between(const MatchedScan& from, const MatchedScan& to) {
  return to_seconds(to.stamp - from.stamp) + to.reference - from.reference;
}

void insert(const MatchedScan& scan, const MotionState& state, LocalMap& map) {
  if (scan.dense.size() > 0) map.insert(scan.dense, state);
}

}  // namespace

void DelayedInitialization::begin() {
  end();
  open_ = true;
}

void DelayedInitialization::end() {
  open_ = false;
  inserted_ = 0;
  scans_.clear();
  filter_.reset();
  found_.clear();
}

void DelayedInitialization::add(MatchedScan scan) {
  if (open_ && !filter_) scans_.push_back(std::move(scan));
}

void DelayedInitialization::set_inserted(const SampledPoints& dense) {
  if (!open_ || filter_) return;
  scans_.back().dense = dense;
  ++inserted_;
}

void DelayedInitialization::set_first(const MotionState& state) { scans_.front().state = state; }

bool DelayedInitialization::is_complete() const {
  return inserted_ >= kInsertedScans ||
         to_seconds(scans_.back().stamp - scans_.front().stamp) > kLongest;
}

std::size_t DelayedInitialization::first_of_later_half() const {
  std::size_t earlier = 0;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    if (scans_[i].dense.size() > 0 && earlier++ == inserted_ / 2) return i;
  }
  return 0;
}

void DelayedInitialization::begin_to_look(const MotionFilter& filter, LocalMap& map) {
  filter_ = filter;
  if (inserted_ < kFewestInserted) return;
  left_ = first_of_later_half();
  found_.resize(left_);
  map.clear();
  for (std::size_t i = left_; i < scans_.size(); ++i) insert(scans_[i], scans_[i].state, map);
  filter_->restart(scans_[left_].state, scans_[left_].covariance);
}

bool DelayedInitialization::match_again(std::size_t i, const MatchJudge& judge, LocalMap& map) {
  const MatchedScan& scan = scans_[i];
  const double seconds = seconds_between(scans_[i + 1], scan);
  MotionFilter high_noise = filter_->with_high_process_noise();
  high_noise.predict(seconds);
  filter_->predict(seconds);
  const registration::MotionBelief belief = filter_->belief();
  const Prediction prediction{belief, belief, high_noise.belief()};
  found_[i] = matcher_.find(scan.points, map, judge, prediction, {});
  const registration::NdtMatch& match = found_[i].match;
  if (judge.judge(match, prediction.high_noise) == TrackingState::kLost) return false;
  filter_->correct(match.state, match.information.inverse(),
                   projection_beside(found_[i].degenerate_directions));
  insert(scan, match.state, map);
  return true;
}

bool DelayedInitialization::look_again(const MotionFilter& filter, const MatchJudge& judge,
                                       LocalMap& map) {
  if (!filter_) {
    if (!is_complete()) return false;
    begin_to_look(filter, map);
    return left_ == 0;
  }
  for (std::size_t k = 0; k < kAtOnce && left_ > 0; ++k) {
    if (match_again(--left_, judge, map)) continue;
    left_ = 0;
    found_.clear();
  }
  return left_ == 0;
}

}  // namespace lidar_mapping::front_end
