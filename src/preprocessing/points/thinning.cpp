// SPDX-License-Identifier: BSD-3-Clause
#include "points/thinning.hpp"

#include <unordered_set>
#include <vector>

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// Keeps the points for which `keep(index)` is true, in their order. Points that it has not been
/// asked about are still in their places.
template <typename Keep>
void keep_if(PointCloud& cloud, const Keep& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keep(i)) continue;
    cloud.points[kept] = cloud.points[i];
    if (cloud.has_times()) cloud.times[kept] = cloud.times[i];
    ++kept;
  }
  cloud.points.resize(kept);
  if (cloud.has_times()) cloud.times.resize(kept);
}

PointCloud first_of_each_voxel(PointCloud cloud, double resolution) {
  const auto inverse = static_cast<float>(1.0 / resolution);
  std::unordered_set<VoxelKey, VoxelKeyHash> seen;
  seen.reserve(cloud.size());
  keep_if(cloud, [&](std::size_t i) {
    return seen.insert(voxel_key(voxel_index(inverse * cloud.points[i].position()))).second;
  });
  return cloud;
}

pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(const PointCloud& cloud) {
  auto result = pcl::PointCloud<pcl::PointXYZ>::Ptr(new pcl::PointCloud<pcl::PointXYZ>);
  result->reserve(cloud.size());
  for (const Point& p : cloud.points) result->push_back(pcl::PointXYZ(p.x, p.y, p.z));
  return result;
}

template <typename Filter>
PointCloud filtered_by(Filter& filter, PointCloud cloud) {
  filter.setInputCloud(to_pcl(cloud));
  std::vector<int> indices;
  filter.filter(indices);
  std::vector<bool> keep(cloud.size(), false);
  for (const int index : indices) keep[index] = true;
  keep_if(cloud, [&](std::size_t i) { return keep[i]; });
  return cloud;
}

}  // namespace

PointCloud downsampled(PointCloud cloud, const PreprocessingConfig& config) {
  if (config.downsample_method == DownsampleMethod::kVoxelGrid) {
    return voxel_filtered(cloud, config.downsample_resolution);
  }
  if (config.downsample_method == DownsampleMethod::kApproximateVoxelGrid) {
    return first_of_each_voxel(std::move(cloud), config.downsample_resolution);
  }
  return cloud;
}

PointCloud without_outliers(PointCloud cloud, const PreprocessingConfig& config) {
  if (cloud.empty()) return cloud;
  if (config.outlier_removal_method == OutlierRemovalMethod::kStatistical) {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
    filter.setMeanK(config.statistical_mean_k);
    filter.setStddevMulThresh(config.statistical_stddev);
    return filtered_by(filter, std::move(cloud));
  }
  if (config.outlier_removal_method == OutlierRemovalMethod::kRadius) {
    pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
    filter.setRadiusSearch(config.radius_radius);
    filter.setMinNeighborsInRadius(config.radius_min_neighbors);
    return filtered_by(filter, std::move(cloud));
  }
  return cloud;
}

}  // namespace lidar_mapping::preprocessing
