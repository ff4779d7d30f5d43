// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/place_pairing.hpp"

#include <utility>

namespace lidar_mapping::pipeline {

namespace {

using localization::LocalizationResult;
using localization::LocalizationState;

/// Key frames that wait for their scans. Chosen: more than come in a second, and the scan follows
/// within milliseconds; bounds the memory.
constexpr std::size_t kMostWaitingKeyFrames = 20;
/// Places that wait for key frames. Chosen: more than a minute of scans, and key frames come up to
/// 7 s later (doc/nodes.md); bounds the memory.
constexpr std::size_t kMostPlaces = 1000;

LocalizationResult unclaimed(Stamp stamp) {
  LocalizationResult place;
  place.stamp = stamp;
  place.state = LocalizationState::kSearching;
  place.reason = "the scan was not localised";
  return place;
}

}  // namespace

void PlacePairing::add(const LocalizationResult& place) {
  if (!begin_) begin_ = place.stamp;
  newest_place_ = place.stamp;
  if (!localization::has_pose(place.state)) {
    found_.reset();
  } else if (!found_) {
    found_ = place.stamp;
  }
  places_[place.stamp] = place;
  if (places_.size() > kMostPlaces) places_.erase(places_.begin());
}

void PlacePairing::add(const RunKeyFrame& received) {
  const Stamp stamp = received.key_frame.stamp;
  if (newest_key_frame_ && stamp <= *newest_key_frame_) return;
  newest_key_frame_ = stamp;
  waiting_.push_back(numbered(received));
}

/// No odometry leads from one run to the next.
KeyFrame PlacePairing::numbered(const RunKeyFrame& received) {
  if (received.run_id != run_id_) {
    run_id_ = received.run_id;
    first_index_ = next_index_;
    first_segment_ = next_segment_;
  }
  KeyFrame key_frame = received.key_frame;
  key_frame.index += first_index_;
  key_frame.segment += first_segment_;
  next_index_ = key_frame.index + 1;
  next_segment_ = key_frame.segment + 1;
  return key_frame;
}

/// Places come in the order of their stamps, so that one that is passed never comes.
std::vector<LocalizedKeyFrame> PlacePairing::take_ready() {
  std::vector<LocalizedKeyFrame> ready;
  while (!waiting_.empty()) {
    const Stamp stamp = waiting_.front().stamp;
    const auto place = places_.find(stamp);
    const bool may_come = place == places_.end() && (!begin_ || stamp > newest_place_);
    if (may_come && waiting_.size() <= kMostWaitingKeyFrames) break;
    if (begin_ && stamp >= *begin_) {
      ready.push_back(
          {std::move(waiting_.front()), place != places_.end() ? place->second : unclaimed(stamp)});
    }
    places_.erase(places_.begin(), places_.upper_bound(stamp));
    waiting_.pop_front();
  }
  return ready;
}

std::optional<Stamp> PlacePairing::withdraw_place() {
  if (!found_) return std::nullopt;
  for (auto place = places_.lower_bound(*found_); place != places_.end(); ++place) {
    place->second.state = LocalizationState::kSearching;
  }
  return std::exchange(found_, std::nullopt);
}

}  // namespace lidar_mapping::pipeline
