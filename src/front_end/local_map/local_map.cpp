// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/local_map.hpp"

#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/vectorization.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Edge of a coarse voxel in fine ones. Chosen: a match then converges from as much further away,
/// and planes are still planes.
constexpr int kCoarseFactor = 3;
/// One of so many points of a full scan enters the coarse map. Chosen: its voxels hold nine times
/// as many of a surface.
constexpr double kCoarseThinning = 4.0;
/// Voxels, 8 MB. Chosen: thrice the ground within 110 m (local_map_radius) in voxels of 1 m.
constexpr std::size_t kFineCapacity = std::size_t{1} << 17;
/// Voxels. Chosen: more than a ninth of kFineCapacity, which is their fraction of a surface.
constexpr std::size_t kCoarseCapacity = std::size_t{1} << 15;
/// Fraction of the tables that is checked for old voxels per scan. Chosen: all within six seconds,
/// in a small part of a scan's time.
constexpr double kAgeingFraction = 1.0 / 64.0;
/// The origin follows the sensor in steps of this length (m). Chosen: so near to it floats are
/// exact to 0.02 mm.
constexpr double kOriginStep = 64.0;

void insert_thinned(SampledPoints& points, std::size_t thinning, GaussianVoxelMap& map) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += thinning, ++kept) {
    points.x[kept] = points.x[i];
    points.y[kept] = points.y[i];
    points.z[kept] = points.z[i];
  }
  map.insert(points.x.data(), points.y.data(), points.z.data(), kept);
}

}  // namespace

// The products are written out so that the compiler can vectorise the loop.
void transform_points(const SampledPoints& points, const MotionState& state,
                      const Eigen::Vector3d& origin, SampledPoints& transformed_points) {
  const Eigen::Matrix3f R = state.T_map_sensor.rotation_matrix().cast<float>();
  const Eigen::Vector3f t = (state.T_map_sensor.translation - origin).cast<float>();
  const Eigen::Vector3f v = state.twist.head<3>().cast<float>();
  const Eigen::Vector3f w = state.twist.tail<3>().cast<float>();
  const float wx = w.x(), wy = w.y(), wz = w.z();
  for (auto* array : {&transformed_points.x, &transformed_points.y, &transformed_points.z})
    array->resize(points.size());
  const float* const px = points.x.data();
  const float* const py = points.y.data();
  const float* const pz = points.z.data();
  const float* const ps = points.s.data();
  float* const qx = transformed_points.x.data();
  float* const qy = transformed_points.y.data();
  float* const qz = transformed_points.z.data();
  LIDAR_MAPPING_INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < points.size(); ++i) {
    float x = px[i], y = py[i], z = pz[i];
    const float s = ps[i];
    const float h = 0.5F * s;
    const float ax = v.x() + (wy * z - wz * y);
    const float ay = v.y() + (wz * x - wx * z);
    const float az = v.z() + (wx * y - wy * x);
    x += s * (ax + h * (wy * az - wz * ay));
    y += s * (ay + h * (wz * ax - wx * az));
    z += s * (az + h * (wx * ay - wy * ax));
    qx[i] = R(0, 0) * x + R(0, 1) * y + R(0, 2) * z + t.x();
    qy[i] = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z + t.y();
    qz[i] = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z + t.z();
  }
}

LocalMap::LocalMap(double voxel_size, double radius)
    : radius_(radius),
      fine_(voxel_size, kFineCapacity),
      coarse_(kCoarseFactor * voxel_size, kCoarseCapacity, registration::PlaneModel::coarse()) {}

void LocalMap::restart(double voxel_size) {
  const Eigen::Vector3d origin = fine_.origin();
  fine_.restart(voxel_size);
  coarse_.restart(kCoarseFactor * voxel_size);
  move_origin(origin);
}

void LocalMap::clear() {
  fine_.clear();
  coarse_.clear();
}

void LocalMap::insert(const SampledPoints& points, const MotionState& state) {
  const std::size_t before = fine_.dropped_points() + coarse_.dropped_points();
  transform_points(points, state, fine_.origin(), transformed_points_);
  std::optional<Eigen::Vector3f> viewpoint;
  if (points.viewpoint) {
    const Eigen::Vector3d p_map = state.T_map_sensor * points.viewpoint->cast<double>();
    viewpoint = (p_map - fine_.origin()).cast<float>();
  }
  fine_.insert(transformed_points_.x.data(), transformed_points_.y.data(),
               transformed_points_.z.data(), transformed_points_.x.size(), viewpoint);
  const auto thinning = std::max<std::size_t>(1, std::lround(kCoarseThinning * scan_density_));
  insert_thinned(transformed_points_, thinning, coarse_);
  dropped_points_ += fine_.dropped_points() + coarse_.dropped_points() - before;
}

void LocalMap::set_center(const Eigen::Vector3d& position) {
  if ((position - fine_.origin()).cwiseAbs().maxCoeff() > kOriginStep) move_origin(position);
  const Eigen::Vector3f center = (position - fine_.origin()).cast<float>();
  fine_.remove_beyond(center, static_cast<float>(radius_), kAgeingFraction);
  coarse_.remove_beyond(center, static_cast<float>(radius_), kAgeingFraction);
}

void LocalMap::move_origin(const Eigen::Vector3d& position) {
  const Eigen::Vector3i cell =
      (position / coarse_.resolution()).array().round().matrix().cast<int>();
  coarse_.set_origin_cell(cell);
  fine_.set_origin_cell(kCoarseFactor * cell);
}

PointCloud LocalMap::cloud() const {
  PointCloud cloud;
  for (const registration::Gaussian& gaussian : fine_.gaussians()) {
    const Eigen::Vector3f p = (gaussian.mean + fine_.origin()).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  }
  return cloud;
}

}  // namespace lidar_mapping::front_end
