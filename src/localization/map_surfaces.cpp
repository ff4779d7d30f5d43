// SPDX-License-Identifier: BSD-3-Clause
#include "map_surfaces.hpp"

#include <vector>

namespace lidar_mapping::localization {

namespace {

/// Edges of the voxels, m, and their ratio, as in local_map.cpp, whose accuracy and convergence are
/// measured on many drives (doc/results/front_end.md).
constexpr double kFineEdge = 1.0;
constexpr int kCoarseFactor = 3;
/// The coarse table has room for one in so many of the fine voxels. Chosen: a surface has a ninth.
constexpr std::size_t kCoarseDivisor = 4;

/// Slots of an empty fine table, 2 MB. Chosen: enough for a yard.
constexpr std::size_t kFirstSlots = std::size_t{1} << 15;
/// Edge of a tile in coarse voxels: 48 m. Chosen: some forty tiles reach as far as a match looks,
/// and a vehicle enters new ones every few seconds.
constexpr int kTileEdge = 16;
/// m beyond kMaxRange, because the position of the LiDAR is rounded to floats. Chosen: far more.
constexpr double kRounding = 1.0;

SurfaceTiles::Options fine_tile_options(std::size_t most_slots) {
  SurfaceTiles::Options options;
  options.voxel_edge = kFineEdge;
  options.tile_edge = kCoarseFactor * kTileEdge;
  options.first_slots = kFirstSlots;
  options.most_slots = most_slots;
  return options;
}

SurfaceTiles::Options coarse_tile_options(std::size_t most_slots) {
  SurfaceTiles::Options options;
  options.voxel_edge = kCoarseFactor * kFineEdge;
  options.model = registration::PlaneModel::coarse();
  options.tile_edge = kTileEdge;
  options.first_slots = kFirstSlots / kCoarseDivisor;
  options.most_slots = most_slots / kCoarseDivisor;
  return options;
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

MapSurfaces::MapSurfaces(std::size_t most_slots, const std::filesystem::path& directory)
    : fine_(fine_tile_options(most_slots), directory),
      coarse_(coarse_tile_options(most_slots), directory) {}

void MapSurfaces::insert(const PointCloud& cloud, const Pose& T_map_base,
                         const Eigen::Vector3d& p_base_lidar) {
  set_center(T_map_base.translation);
  Pose T_origin_base = T_map_base;
  T_origin_base.translation -= fine().origin();
  const Coordinates points = near_points(cloud, T_origin_base, p_base_lidar.cast<float>());
  const Eigen::Vector3f viewpoint = (T_origin_base * p_base_lidar).cast<float>();
  const Eigen::Vector3d p_map_lidar = T_map_base * p_base_lidar;
  constexpr double kReach = kMaxRange + kRounding;
  fine_.insert(p_map_lidar, kReach, points.x.data(), points.y.data(), points.z.data(),
               points.x.size(), viewpoint);
  // Else the floor of a storey and the ceiling below it would be one surface in the middle.
  fine().update_planes(points.x.data(), points.y.data(), points.z.data(), points.x.size(),
                       viewpoint);
  coarse_.insert(p_map_lidar, kReach, points.x.data(), points.y.data(), points.z.data(),
                 points.x.size());
}

void MapSurfaces::require(const Eigen::Vector3d& position, double radius) {
  set_center(position);
  fine_.require(position, radius);
  coarse_.require(position, radius);
}

void MapSurfaces::set_center(const Eigen::Vector3d& position) {
  const VoxelIndex cell = voxel_index(position / coarse().resolution());
  coarse().set_origin_cell(cell);
  fine().set_origin_cell(kCoarseFactor * cell);
}

}  // namespace lidar_mapping::localization
