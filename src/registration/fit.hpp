#pragma once

#include <pcl/search/kdtree.h>

#include "lidar_mapping/common/pose.hpp"

#include "pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// How well a source lies on a target; the fields mean what those of RegistrationResult mean.
struct Fit {
  double fitness = 0.0;
  double inlier_fraction = 0.0;
  double overlap = 0.0;
  Matrix6d hessian = Matrix6d::Zero();
};

/// Judges T_target_source by the nearest neighbours of the source's points in the target, whose
/// search tree is `tree`, up to `max_range` (m). Methods that only return a pose are measured alike
/// by it. The Hessian is that of the distances to the planes through the neighbours.
Fit evaluate_fit(const pcl::search::KdTree<pcl::PointXYZ>& tree, const PclCloud& source,
                 const Pose& T_target_source, double max_range);

}  // namespace lidar_mapping::registration
