// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// The result of matching a pair of key frames that a person chose.
struct PairMatch {
  LoopVerdict verdict;       ///< figures of the match, and the reason if there is no loop
  std::optional<Loop> loop;  ///< empty if the match is not accepted; its source is kManual
};

/// Matches key frame `to` with the submap around the older key frame `from`, as LoopCloser does
/// with a candidate. Only the checks of the clouds apply, not those of distance and estimate. The
/// registration starts at `guess`, a guess of T_from_to. Without a guess it starts at the identity
/// and where the two bird's-eye views agree best. `p_base_lidar` is the position of the LiDAR in
/// base_link (m); `key_frames` are those of the drive by increasing index, without clouds. Throws
/// InputError if one of the two is unknown, or if `from` is not old enough: scan and submap would
/// share clouds.
PairMatch match_pair(const LoopClosingConfig& config, CloudSource& clouds,
                     const Eigen::Vector3d& p_base_lidar, const std::vector<KeyFrame>& key_frames,
                     KeyFrameIndex from, KeyFrameIndex to, const std::optional<Pose>& guess);

}  // namespace lidar_mapping::loop_closing
