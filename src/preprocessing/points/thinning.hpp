// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// The cloud after `downsample_method`. Voxels have 64-bit keys, so that clouds of any extent are
/// possible.
PointCloud downsampled(PointCloud cloud, const PreprocessingConfig& config);

/// The cloud after `outlier_removal_method` (PCL's filters; Rusu et al. 2008 for STATISTICAL).
/// Intensities and times stay with their points.
PointCloud without_outliers(PointCloud cloud, const PreprocessingConfig& config);

}  // namespace lidar_mapping::preprocessing
