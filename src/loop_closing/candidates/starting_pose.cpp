// SPDX-License-Identifier: BSD-3-Clause
#include "candidates/starting_pose.hpp"

#include <algorithm>

namespace lidar_mapping::loop_closing {

namespace {

// m; below it the estimate is a better starting pose than the views. Chosen: the views have errors
// of half a metre, by their cells of 1 m.
constexpr double kTrustedHorizontal = 0.7;
constexpr double kTrustedRotation = 0.35;  // rad; chosen: views that are turned by it still overlap
// Least number of occupied cells for a view to be used. Chosen: fewer agree by chance.
constexpr std::size_t kMinCells = 30;

}  // namespace

StartingPose starting_pose_by_views(const Prior& prior, const std::optional<Appearance>& older,
                                    const std::optional<Appearance>& newer,
                                    const std::vector<Eigen::Vector2f>& cells) {
  StartingPose start{
      planar_pose(prior.T_from_to.translation.head<2>(), yaw_of(prior.T_from_to.rotation)), 0.0};
  if (!older || !newer || std::min(older->view.count(), cells.size()) < kMinCells) return start;
  const std::array<double, 2> headings = headings_by_views(*older, *newer);
  std::vector<double> candidate_yaws(headings.begin(), headings.end());
  if (prior.anchored && prior.sigma_rotation < kTrustedRotation) {
    candidate_yaws.push_back(yaw_of(prior.T_from_to.rotation));
  }
  const ViewCorrelator correlator(older->view);
  for (const double candidate_yaw : candidate_yaws) {
    const ViewMatch match = correlator.match(cells, candidate_yaw);
    if (match.score <= start.score) continue;
    start.score = match.score;
    if (prior.anchored && prior.sigma_horizontal < kTrustedHorizontal) continue;
    start.T_from_to = planar_pose(match.translation, candidate_yaw);
  }
  return start;
}

}  // namespace lidar_mapping::loop_closing
