// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "prior.hpp"

namespace lidar_mapping::loop_closing {

/// Where to start the registration of two key frames.
struct StartingPose {
  Pose T_from_to;
  double score = 0.0;  ///< how well the two views from above agree there, 0 to 1
};

/// Tries the headings that the estimate and the descriptors suggest and keeps the one from which
/// the two views agree best. `cells` are those of the newer view.
StartingPose starting_pose_by_views(const Prior& prior, const std::optional<Appearance>& older,
                                    const std::optional<Appearance>& newer,
                                    const std::vector<Eigen::Vector2f>& cells);

}  // namespace lidar_mapping::loop_closing
