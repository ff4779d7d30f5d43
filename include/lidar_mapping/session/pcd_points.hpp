// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <pcl/PCLPointCloud2.h>

#include "lidar_mapping/common/pcd_header.hpp"

namespace lidar_mapping::session {

/// Reads all fields of the points of a PCD file in PCL's layout; the result is empty if the header
/// announces no points. PCL decodes ASCII and compressed points, but does not read the header: it
/// could take points after the line DATA for further lines of the header. Throws FileError.
pcl::PCLPointCloud2 read_pcd_points(const std::filesystem::path& path, const PcdHeader& header);

}  // namespace lidar_mapping::session
