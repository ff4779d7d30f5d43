#include "lidar_mapping/front_end/first_scans.hpp"

#include <utility>

#include "lidar_mapping/front_end/degeneracy.hpp"

namespace lidar_mapping::front_end {

namespace {

/// In half of so many scans the planes of few rings stand upright.
constexpr std::size_t kInsertedScans = 24;
/// A slow vehicle does not get so far: key frames are not to wait longer, s.
constexpr double kLongest = 6.0;
/// Of fewer nothing better can be made.
constexpr std::size_t kFewestInserted = 6;

double seconds_between(const MatchedScan& from, const MatchedScan& to) {
  return to_seconds(to.stamp - from.stamp) + to.reference - from.reference;
}

void insert(const MatchedScan& scan, const MotionState& state, LocalMap& map) {
  if (scan.dense.size() > 0) map.insert(scan.dense, state);
}

}  // namespace

void FirstScans::begin() {
  end();
  open_ = true;
}

void FirstScans::end() {
  open_ = false;
  inserted_ = 0;
  scans_.clear();
}

void FirstScans::add(MatchedScan scan) {
  if (open_) scans_.push_back(std::move(scan));
}

void FirstScans::set_inserted(const SampledPoints& dense) {
  if (!open_) return;
  scans_.back().dense = dense;
  ++inserted_;
}

void FirstScans::set_first(const MotionState& state) { scans_.front().state = state; }

bool FirstScans::is_complete() const {
  return inserted_ >= kInsertedScans ||
         to_seconds(scans_.back().stamp - scans_.front().stamp) > kLongest;
}

std::size_t FirstScans::first_of_later_half() const {
  std::size_t earlier = 0;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    if (scans_[i].dense.size() > 0 && earlier++ == inserted_ / 2) return i;
  }
  return 0;
}

std::vector<SweepMatcher::Found> FirstScans::match_again(MotionFilter filter, SweepMatcher& matcher,
                                                         const MatchJudge& judge,
                                                         LocalMap& map) const {
  if (inserted_ < kFewestInserted) return {};
  const std::size_t later = first_of_later_half();
  map.clear();
  for (std::size_t i = later; i < scans_.size(); ++i) insert(scans_[i], scans_[i].state, map);
  filter.restart(scans_[later].state, scans_[later].covariance);
  std::vector<SweepMatcher::Found> found(later);
  for (std::size_t i = later; i-- > 0;) {
    filter.predict(seconds_between(scans_[i + 1], scans_[i]));
    const registration::MotionBelief belief = filter.belief();
    found[i] = matcher.find(scans_[i].points, map, judge, {belief, belief}, {});
    if (judge.judge(found[i].match, belief) == TrackingState::kLost) {
      restore(map);
      return {};
    }
    filter.correct(found[i].match.state, found[i].match.information.inverse(),
                   projection_beside(found[i].degenerate_directions));
    insert(scans_[i], found[i].match.state, map);
  }
  return found;
}

void FirstScans::restore(LocalMap& map) const {
  map.clear();
  for (const MatchedScan& scan : scans_) insert(scan, scan.state, map);
}

}  // namespace lidar_mapping::front_end
