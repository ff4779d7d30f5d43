// SPDX-License-Identifier: BSD-3-Clause
#include "scan_points.hpp"

#include <algorithm>

#include "lidar_mapping/common/scattering_step.hpp"
#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/loop_closing/above_ground.hpp"

#include "map_surfaces.hpp"

namespace lidar_mapping::localization {

namespace {

/// m; one point per cube of this edge: the default of scan_resolution in the front end.
constexpr float kCube = 0.8F;
/// Points of a scan that are looked at. Chosen: cubes then have a point each, also with 16 beams.
constexpr std::size_t kMostVisited = 40'000;
/// Cubes of a scan that are matched, which bounds the time of a match. Chosen: about twice what
/// a scan with 64 beams has.
constexpr std::size_t kMostCubes = std::size_t{1} << 14;
/// m from the LiDAR, as in verification.cpp: beyond it points are too sparse to judge.
constexpr float kJudgedRange = 40.0F;

}  // namespace

registration::NdtPoints ndt_points(const std::vector<Eigen::Vector3f>& points,
                                   const std::optional<Eigen::Vector3f>& viewpoint) {
  std::vector<float> x, y, z;
  for (const Eigen::Vector3f& p : points) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
  registration::NdtPoints result;
  result.assign(x, y, z, std::vector<float>(x.size(), 0.0F), viewpoint);
  return result;
}

bool ScanPointSampler::is_new_cube(const Eigen::Vector3f& p) {
  const std::size_t before = cubes_.size();
  cubes_.find_or_add(voxel_key(voxel_index(p / kCube)));
  return cubes_.size() > before;
}

ScanPoints ScanPointSampler::sample(const PointCloud& cloud, const Eigen::Vector3d& p_base_lidar) {
  cubes_.clear();
  const Eigen::Vector3f viewpoint = p_base_lidar.cast<float>();
  std::vector<Eigen::Vector3f> all, near, structure;
  // So that any point of a cube may be the one that is taken, and that a bound leaves out points
  // everywhere alike.
  const std::size_t step = scattering_step(cloud.size());
  const std::size_t visited = std::min(cloud.size(), kMostVisited);
  for (std::size_t k = 0, i = 0; k < visited && cubes_.size() < kMostCubes;
       ++k, i = (i + step) % cloud.size()) {
    const Eigen::Vector3f p = cloud.points[i].position();
    const float squared_range = (p - viewpoint).squaredNorm();
    if (!(squared_range < kMaxRange * kMaxRange) || !is_new_cube(p)) continue;  // also not NaN
    all.push_back(p);
    if (squared_range < kJudgedRange * kJudgedRange) near.push_back(p);
  }
  const std::vector<bool> is_above = loop_closing::above_ground(near);
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (is_above[i]) structure.push_back(near[i]);
  }
  return {ndt_points(all, viewpoint), ndt_points(near, viewpoint),
          ndt_points(structure, viewpoint)};
}

}  // namespace lidar_mapping::localization
