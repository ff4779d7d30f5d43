// SPDX-License-Identifier: BSD-3-Clause
#include "place_finder.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::localization {

namespace {

/// Candidates that are verified per second of driving, so that a core keeps up: each takes 30 to
/// 45 ms of it (doc/results/localization.md).
constexpr double kVerificationsPerSecond = 20.0;
/// Fewest candidates that are verified with one scan. Chosen.
constexpr std::size_t kLeastVerificationsPerScan = 2;
/// A search follows the last one after this distance (m) or so many scans. Chosen: it then sees the
/// place from elsewhere, or with other noise.
constexpr double kSearchDistance = 1.0;
constexpr int kSearchScans = 5;
/// A place is certain from this probability on, if so many searches led to it. Chosen: two places
/// that look alike have less than a half, and one search may lead to a wrong one.
constexpr double kCertain = 0.99;
constexpr int kLeastVerifications = 2;
/// m around a claimed pose, seen from above, within which it is believed. Chosen: rviz is clicked
/// better than that, and gives no height.
constexpr double kClaimRadius = 20.0;
/// Searches without a place near the claim, after which it is not believed any more. Chosen.
constexpr int kClaimSearches = 2;

}  // namespace

PlaceFinder::PlaceFinder(MapParts& map)
    : map_(map),
      recent_(map.places.verification().map_leaf(), map.places.verification().scan_leaf()) {}

void PlaceFinder::restart() {
  recent_.clear();
  hypotheses_.clear();
  candidates_.clear();
  claim_.reset();
  last_scan_.reset();
  is_searching_ = false;
  searches_ = 0;
  scans_ = 0;
  distance_ = 0.0;
}

void PlaceFinder::move(const Pose& T_previous_base, const Covariance6& covariance) {
  T_start_base_ = T_start_base_ * T_previous_base;
  for (Pose& candidate : candidates_) candidate = candidate * T_previous_base;
  if (claim_) claim_->T_map_base = claim_->T_map_base * T_previous_base;
  hypotheses_.move(T_previous_base, covariance);
}

std::optional<Hypothesis> PlaceFinder::search(const LocalizerInput& input, const ScanPoints& points,
                                              MapMatcher& matcher, double distance) {
  recent_.add(input.scan.cloud, T_start_base_, input.p_base_lidar);
  distance_ += distance;
  ++scans_;
  hypotheses_.update(points, map_.surfaces, matcher, distance);
  if (is_search_due()) begin_search();
  if (is_searching_) verify(candidates_due(input.scan.stamp));
  last_scan_ = input.scan.stamp;
  return certain();
}

/// Scans that follow each other slowly leave more time for each.
std::size_t PlaceFinder::candidates_due(Stamp stamp) const {
  const double interval = last_scan_ ? to_seconds(stamp - *last_scan_) : 0.0;
  const auto due = static_cast<std::size_t>(std::lround(kVerificationsPerSecond * interval));
  return std::max(due, kLeastVerificationsPerScan);
}

bool PlaceFinder::is_search_due() const {
  if (is_searching_) return false;
  return searches_ == 0 || has_gone_on();
}

/// A verification then sees the place from elsewhere, or with other noise.
bool PlaceFinder::has_gone_on() const {
  return distance_ >= kSearchDistance || scans_ >= kSearchScans;
}

PlaceFinder::Confirmed PlaceFinder::confirm(const LocalizerInput& input, const Pose& T_map_base,
                                            double distance) {
  distance_ += distance;
  ++scans_;
  if (!has_gone_on()) return {};
  distance_ = 0.0;
  scans_ = 0;
  recent_.add(input.scan.cloud, T_start_base_, input.p_base_lidar);
  map_.places.set_query(recent_.query());
  const auto verified = map_.places.verified(T_map_base);
  if (!verified) return {Confirmation::kRefused, {}};
  return {Confirmation::kAccepted, *verified};
}

/// Places that are possible already are verified again first; candidates for what is known are left
/// out.
void PlaceFinder::begin_search() {
  distance_ = 0.0;
  scans_ = 0;
  is_searching_ = true;
  hypotheses_.begin_search();
  std::vector<Pose> known;
  for (const Hypothesis& hypothesis : hypotheses_.all()) {
    known.push_back(hypothesis.estimate().T_map_base);
    if (hypothesis.is_possible()) candidates_.push_back(known.back());
  }
  std::vector<Pose> found = map_.places.candidates(recent_.newest());
  if (claim_) {
    const auto near = map_.places.candidates_near(claim_->T_map_base, recent_.newest());
    found.insert(found.begin(), near.begin(), near.end());
  }
  for (const Pose& pose : found) {
    const bool is_known = std::any_of(
        known.begin(), known.end(), [&](const Pose& other) { return is_same_place(other, pose); });
    if (!is_known) candidates_.push_back(pose);
  }
}

void PlaceFinder::verify(std::size_t count) {
  map_.places.set_query(recent_.query());
  for (std::size_t i = 0; i < count && !candidates_.empty(); ++i) {
    const auto verified = map_.places.verified(candidates_.front());
    candidates_.pop_front();
    if (verified) hypotheses_.verify(*verified);
  }
  if (candidates_.empty()) end_search();
}

void PlaceFinder::end_search() {
  is_searching_ = false;
  ++searches_;
  if (!claim_) return;
  Hypotheses near = hypotheses_;
  near.keep_near(claim_->T_map_base, kClaimRadius);
  if (near.size() > 0) {
    hypotheses_ = near;
  } else if (++claim_->searches >= kClaimSearches) {
    claim_.reset();
  }
}

/// No other place may be left that was not looked at.
std::optional<Hypothesis> PlaceFinder::certain() const {
  const Hypothesis* const best = hypotheses_.best();
  if (best == nullptr || is_searching_ || claim_contradicts(*best)) return std::nullopt;
  if (best->verifications() < kLeastVerifications) return std::nullopt;
  if (hypotheses_.probability() < kCertain) return std::nullopt;
  if (best->evidence() != Evidence::kAgrees) return std::nullopt;
  return *best;
}

bool PlaceFinder::claim_contradicts(const Hypothesis& place) const {
  if (!claim_) return false;
  const Eigen::Vector3d between =
      place.estimate().T_map_base.translation - claim_->T_map_base.translation;
  return between.head<2>().norm() > kClaimRadius;
}

std::string PlaceFinder::reason() const {
  if (hypotheses_.size() == 0) return "no place in the map matches the scan";
  if (hypotheses_.size() == 1) return "one place is possible, but it is not confirmed yet";
  return formatted("%zu places look alike; the search continues while the vehicle drives on",
                   hypotheses_.size());
}

}  // namespace lidar_mapping::localization
