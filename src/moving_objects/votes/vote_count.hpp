// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "visibility/observing_scan.hpp"

namespace lidar_mapping::moving_objects {

/// Number of voters, and of those that vote moving.
struct VoteCount {
  int voters = 0;
  int moving = 0;

  void add(const VoteCount& other) {
    voters += other.voters;
    moving += other.moving;
  }
  bool is_moving(double fraction) const { return static_cast<double>(moving) > fraction * voters; }
};

/// The count of a single vote.
inline VoteCount vote_count_of(Vote vote) {
  return {vote == Vote::kUnseen ? 0 : 1, vote == Vote::kMoving ? 1 : 0};
}

}  // namespace lidar_mapping::moving_objects
