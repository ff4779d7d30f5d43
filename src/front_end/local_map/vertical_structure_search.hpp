// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "local_map/vertical_structure_map.hpp"

namespace lidar_mapping::front_end {

/// A new pose needs more evidence than the old one by this factor. Chosen: the best of many poses
/// has a little more by chance.
constexpr double kMinEvidenceRatio = 1.25;

/// Points on vertical structures, deskewed with this twist to the reference time.
std::vector<Eigen::Vector3f> vertical_points_at(const SampledPoints& points, const Vector6d& twist);
/// A subset of these points, a few hundred: more points, as in streets, cost time without benefit.
std::vector<Eigen::Vector3f> sampled_vertical_points_at(const SampledPoints& points,
                                                        const Vector6d& twist);

/// Unit vector in the direction of the displacement; the sensor's x axis if there is no
/// displacement.
Eigen::Vector2d heading_of(const Vector6d& displacement);

/// The pose around `center` at which most points lie near points of the map. The search covers a
/// few metres ahead and behind, for four directions of travel.
Pose coarse_search(const VerticalStructureMap& map, const std::vector<Eigen::Vector3f>& points,
                   const Pose& center);

/// True if the points fit at this pose, and fit worse at poses behind and ahead of it. `ahead` is
/// the direction of travel in the sensor's axes.
bool is_distinct(const VerticalStructureMap& map, const VerticalStructureMap::Fit& fit,
                 const Eigen::Vector2d& ahead, const std::vector<Eigen::Vector3f>& points);

}  // namespace lidar_mapping::front_end
