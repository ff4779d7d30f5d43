// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include <pcl/search/kdtree.h>

#include "lidar_mapping/common/plane_fit.hpp"
#include "lidar_mapping/registration/registration.hpp"

#include "pcl_methods/pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// Least number of points of a cloud: as many as generalised ICP takes for one covariance (default
/// of correspondence_randomness).
constexpr std::size_t kLeastPoints = 20;

/// The plane through points of a cloud; none where they lie on a line or fill a volume.
std::optional<PlaneFit> fit_plane(const PclCloud& cloud, const pcl::Indices& indices);

/// Evaluates T_target_source by the nearest neighbours of the source's points in the target, whose
/// search tree is `tree`, up to `max_range` (m). So methods that only return a pose have the same
/// figures as others. The Hessian is that of the distances to the planes through the neighbours.
/// The caller adds convergence and iterations to the result.
RegistrationResult evaluate_fit(const pcl::search::KdTree<pcl::PointXYZ>& tree,
                                const PclCloud& source, const Pose& T_target_source,
                                double max_range);

}  // namespace lidar_mapping::registration
