// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::registration {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

/// The finite points of a cloud: PCL's search trees refuse others.
PclCloud::Ptr to_pcl(const PointCloud& cloud);

/// Mean of the points; zero of none.
Eigen::Vector3d middle_of(const PclCloud& cloud);

}  // namespace lidar_mapping::registration
