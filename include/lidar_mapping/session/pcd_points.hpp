// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <pcl/PCLPointCloud2.h>

#include "lidar_mapping/common/pcd_header.hpp"

namespace lidar_mapping::session {

/// All fields of the points of a PCD file, in PCL's layout; none where the header says so. PCL
/// decodes texts and compressed points, but gets to see no header: it would take what stands behind
/// DATA for more of it if it looks so. Throws FileError.
pcl::PCLPointCloud2 read_pcd_points(const std::filesystem::path& path, const PcdHeader& header);

}  // namespace lidar_mapping::session
