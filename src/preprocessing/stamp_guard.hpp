// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::preprocessing {

/// A stamp that is older than the newest one by more shows that the recording has started again.
/// Chosen: longer than any network delay.
constexpr Stamp kJumpBack = from_seconds(2.0);

/// Distinguishes a single wrong stamp from a jump of time: a jump is accepted when the next stamp
/// confirms it.
class StampGuard {
 public:
  /// `now` is the latest time of all inputs. Returns false for a stamp that is far from it and from
  /// all previous stamps, until the next stamp confirms it.
  bool accepts(Stamp stamp, Stamp now) {
    const std::optional<Stamp> refused = std::exchange(unconfirmed_, std::nullopt);
    if (!newest_ || follows(*newest_, stamp) || (stamp > *newest_ && follows(now, stamp))) {
      newest_ = std::max(newest_.value_or(stamp), stamp);
    } else if (refused && follows(*refused, stamp)) {
      newest_ = stamp;
    } else {
      unconfirmed_ = stamp;
      return false;
    }
    return true;
  }

  /// The newest accepted stamp; 0 if there is none.
  Stamp newest() const { return newest_.value_or(0); }

 private:
  static bool follows(Stamp before, Stamp stamp) {
    constexpr Stamp kMaxForward = from_seconds(10.0);  // longer than a pause of a sensor; chosen
    return stamp >= before - kJumpBack && stamp <= before + kMaxForward;
  }

  std::optional<Stamp> newest_;
  std::optional<Stamp> unconfirmed_;
};

}  // namespace lidar_mapping::preprocessing
