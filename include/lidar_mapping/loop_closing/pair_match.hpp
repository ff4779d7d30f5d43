// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// What matching made of a pair of key frames that somebody named.
struct PairMatch {
  LoopVerdict verdict;       ///< with the reason where there is no loop
  std::optional<Loop> loop;  ///< source manual
};

/// Matches key frame `to` against the submap around the older key frame `from`, as LoopCloser does
/// with a candidate, and holds the match against the rules that look at the clouds alone: neither
/// distance nor estimate objects. Starts at the guess of T_from_to, or else at the same place and
/// where the two views from above agree best. `key_frames` is the drive, by index, without clouds.
/// Throws InputError unless both are in it and from is so much older that they share no cloud.
PairMatch match_pair(const LoopClosingConfig& config, CloudSource& clouds,
                     const Eigen::Vector3d& p_base_lidar, const std::vector<KeyFrame>& key_frames,
                     KeyFrameIndex from, KeyFrameIndex to, const std::optional<Pose>& guess);

}  // namespace lidar_mapping::loop_closing
