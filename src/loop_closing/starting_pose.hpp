// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "prior.hpp"

namespace lidar_mapping::loop_closing {

/// A starting pose on the same ground plane: roll, pitch and height are left to the registration.
Pose planar_pose(const Eigen::Vector2d& translation, double yaw);
/// The two headings (rad) of the newer in the older scan that the descriptors allow.
std::array<double, 2> headings_by_views(const Appearance& older, const Appearance& newer);

/// Starting pose for the registration of two key frames.
struct StartingPose {
  Pose T_from_to;
  double score = 0.0;  ///< agreement of the two bird's-eye views at this pose, 0 to 1
};

/// Tries the headings of the estimate and of the descriptors, and returns the pose with the best
/// agreement of the two views. `cells` are those of the newer view.
StartingPose starting_pose_by_views(const Prior& prior, const std::optional<Appearance>& older,
                                    const std::optional<Appearance>& newer,
                                    const std::vector<Eigen::Vector2f>& cells);

}  // namespace lidar_mapping::loop_closing
