// SPDX-License-Identifier: BSD-3-Clause
#include "map_surfaces.hpp"

#include <algorithm>
#include <vector>

namespace lidar_mapping::localization {

namespace {

/// Edges of the voxels, m, and their ratio, as in local_map.cpp, whose accuracy and convergence are
/// measured on many drives (doc/results/front_end.md).
constexpr double kFineEdge = 1.0;
constexpr int kCoarseFactor = 3;
/// Share of the fine voxels for which the coarse table has room. Chosen: a surface has a ninth.
constexpr std::size_t kCoarseShare = 4;

/// Memory of a table, which has a power of two of slots.
std::size_t table_bytes(std::size_t capacity) {
  std::size_t slots = 1;
  while (slots < capacity) slots *= 2;
  return slots * sizeof(registration::VoxelSums);
}

/// Coordinates of points in arrays of their own, relative to the map's origin.
struct Coordinates {
  std::vector<float> x, y, z;
};

Coordinates near_points(const PointCloud& cloud, const Pose& T_origin_base,
                        const Eigen::Vector3f& p_base_lidar) {
  Coordinates result;
  const Eigen::Matrix3f R = T_origin_base.rotation_matrix().cast<float>();
  const Eigen::Vector3f t = T_origin_base.translation.cast<float>();
  for (const Point& point : cloud.points) {
    const Eigen::Vector3f p = point.position();
    if (!((p - p_base_lidar).squaredNorm() < kMaxRange * kMaxRange)) continue;  // also not NaN
    const Eigen::Vector3f q = R * p + t;
    result.x.push_back(q.x());
    result.y.push_back(q.y());
    result.z.push_back(q.z());
  }
  return result;
}

}  // namespace

MapSurfaces::MapSurfaces(std::size_t capacity)
    : bytes_(table_bytes(capacity) + table_bytes(capacity / kCoarseShare)),
      fine_(kFineEdge, capacity),
      coarse_(kCoarseFactor * kFineEdge, capacity / kCoarseShare,
              registration::PlaneModel::coarse()) {}

void MapSurfaces::insert(const PointCloud& cloud, const Pose& T_map_base,
                         const Eigen::Vector3d& p_base_lidar) {
  set_center(T_map_base.translation);
  Pose T_origin_base = T_map_base;
  T_origin_base.translation -= fine_.origin();
  const Coordinates points = near_points(cloud, T_origin_base, p_base_lidar.cast<float>());
  const Eigen::Vector3f viewpoint = (T_origin_base * p_base_lidar).cast<float>();
  fine_.insert(points.x.data(), points.y.data(), points.z.data(), points.x.size(), viewpoint);
  // Else the floor of a storey and the ceiling below it would be one surface in the middle.
  fine_.update_planes(points.x.data(), points.y.data(), points.z.data(), points.x.size(),
                      viewpoint);
  coarse_.insert(points.x.data(), points.y.data(), points.z.data(), points.x.size());
}

void MapSurfaces::set_center(const Eigen::Vector3d& position) {
  const VoxelIndex cell = voxel_index(position / coarse_.resolution());
  coarse_.set_origin_cell(cell);
  fine_.set_origin_cell(kCoarseFactor * cell);
}

}  // namespace lidar_mapping::localization
