// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "candidates/prior.hpp"

namespace lidar_mapping::loop_closing {

/// Starting pose for the registration of two key frames; roll, pitch and height are left to it.
struct StartingPose {
  Pose T_from_to;
  double score = 0.0;  ///< best ViewMatch::score of the two bird's-eye views
};

/// Tries the headings of the estimate and of the descriptors, and returns the pose with the best
/// agreement of the two views. `cells` are those of the newer view.
StartingPose starting_pose_by_views(const Prior& prior, const std::optional<Appearance>& older,
                                    const std::optional<Appearance>& newer,
                                    const std::vector<Eigen::Vector2f>& cells);

}  // namespace lidar_mapping::loop_closing
