// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "lidar_mapping/common/voxel_index.hpp"

#include "voxels/weighted_normal.hpp"

namespace lidar_mapping::registration {
namespace {

/// Bit of the key of the Gaussian for the side of a voxel's plane that was observed second.
constexpr VoxelKey kBack = VoxelKey{1} << (3 * kVoxelKeyBits);
/// Points of a voxel; the field count_at_plane has 15 bits.
constexpr std::uint16_t kMaxCount = std::numeric_limits<std::int16_t>::max();
// Standard deviation, m, below which a plane may have two sides, and the sine of the angle between
// plane and view below which a view does not show which side is observed. Both chosen: three times
// the noise of a LiDAR (1 to 2 cm), and 1.7 degrees, the error of a normal from a few points.
constexpr float kThinSurface = 0.05F;
constexpr float kMinViewSlope = 0.03F;
/// A plane is computed again when its voxel has this percentage of the points that it had. Chosen:
/// each computation is an eigenvalue problem, and 10 % more points hardly move the plane.
constexpr int kGrowthPercent = 110;
// Distance of neighbouring rings in edges of the voxel, up to which a voxel is crossed by several
// rings at a time, and from which on by one: geometry, one edge with a ramp of a quarter around it.
constexpr float kSeveralRings = 0.75F;
constexpr float kOneRing = 1.25F;

Eigen::Matrix3d symmetric(double xx, double xy, double xz, double yy, double yz, double zz) {
  Eigen::Matrix3d matrix;
  matrix << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return matrix;
}

/// Splits coordinates into the number of the voxel and the distance from its centre.
void split(const float* values, std::size_t count, float inverse_resolution, float resolution,
           int* cells, float* offsets) {
  for (std::size_t i = 0; i < count; ++i) {
    const float scaled = inverse_resolution * values[i];
    const int lower = floor_to_int(scaled);
    cells[i] = lower;
    offsets[i] = resolution * (scaled - static_cast<float>(lower) - 0.5F);
  }
}

float dot(const std::array<float, 3>& a, const Eigen::Vector3f& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// True if `view` is steep enough on the plane to show which side is observed.
bool shows_side(const std::array<float, 3>& normal, const Eigen::Vector3f& view, float along) {
  const Eigen::Vector3f n(normal[0], normal[1], normal[2]);
  return along * along > kMinViewSlope * kMinViewSlope * n.squaredNorm() * view.squaredNorm();
}

/// Turns the normal of a voxel to the side from which it is observed.
void turn_to_front(VoxelSums& voxel, const Eigen::Vector3f& view) {
  const float along = dot(voxel.normal, view);
  if (!shows_side(voxel.normal, view, along)) return;
  voxel.has_front = 1;
  if (along > 0.0F) return;
  for (float& value : voxel.normal) value = -value;
  voxel.offset = -voxel.offset;
}

/// True if the sensor observes the back of the plane.
bool is_behind(const VoxelSums& voxel, const Eigen::Vector3f& view) {
  if (voxel.has_front == 0) return false;
  const float along = dot(voxel.normal, view);
  if (along >= 0.0F) return false;
  const auto& n = voxel.normal;
  const float sharpness = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  return sharpness > 1.0F / (kThinSurface * kThinSurface) && shows_side(n, view, along);
}

}  // namespace

GaussianVoxelMap::GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model)
    : resolution_(resolution),
      inverse_resolution_(static_cast<float>(1.0 / resolution)),
      model_(model),
      table_(capacity) {}

void GaussianVoxelMap::clear() {
  table_.clear();
  dropped_points_ = 0;
}

void GaussianVoxelMap::restart(double resolution) {
  clear();
  resolution_ = resolution;
  inverse_resolution_ = static_cast<float>(1.0 / resolution);
  origin_cell_.setZero();
}

/// The Gaussian that a point belongs to whose sensor lies in the direction `view`.
VoxelSums* GaussianVoxelMap::observed_side(const VoxelTable::Slot& slot,
                                           const Eigen::Vector3f& view) {
  VoxelSums* const voxel = table_.find_or_add(slot);
  if (voxel == nullptr) return nullptr;
  if (voxel->count_at_plane == 0) {
    voxel->normal = {view.x(), view.y(), view.z()};
    return voxel;
  }
  if (voxel->has_front == 0) {
    turn_to_front(*voxel, view);
  } else if (is_behind(*voxel, view) && (slot.key & kBack) == 0) {
    return observed_side(table_.slot_of(slot.key | kBack), view);
  }
  return voxel;
}

/// `p` is relative to the voxel's centre.
void GaussianVoxelMap::add_point(VoxelSums* voxel, float px, float py, float pz) {
  if (voxel == nullptr) {
    ++dropped_points_;
    return;
  }
  // A voxel with that many points does not change any more.
  if (voxel->count == kMaxCount) return;
  ++voxel->count;
  voxel->sum[0] += px;
  voxel->sum[1] += py;
  voxel->sum[2] += pz;
  voxel->products[0] += px * px;
  voxel->products[1] += px * py;
  voxel->products[2] += px * pz;
  voxel->products[3] += py * py;
  voxel->products[4] += py * pz;
  voxel->products[5] += pz * pz;
}

void GaussianVoxelMap::insert(const float* x, const float* y, const float* z, std::size_t count,
                              const std::optional<Eigen::Vector3f>& viewpoint) {
  constexpr std::size_t kBlock = 64;  // points, so few that they stay in the cache; chosen
  const float* const coordinates[3] = {x, y, z};
  int cells[3][kBlock];
  float offsets[3][kBlock];
  VoxelTable::Slot slots[kBlock];
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(kBlock, count - begin);
    for (int axis = 0; axis < 3; ++axis) {
      split(coordinates[axis] + begin, size, inverse_resolution_, static_cast<float>(resolution_),
            cells[axis], offsets[axis]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      slots[i] = slot_of(VoxelIndex(cells[0][i], cells[1][i], cells[2][i]));
      prefetch(slots[i]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t p = begin + i;
      VoxelSums* const voxel =
          viewpoint ? observed_side(slots[i], *viewpoint - Eigen::Vector3f(x[p], y[p], z[p]))
                    : table_.find_or_add(slots[i]);
      add_point(voxel, offsets[0][i], offsets[1][i], offsets[2][i]);
    }
  }
}

void GaussianVoxelMap::update_planes(const float* x, const float* y, const float* z,
                                     std::size_t count, const Eigen::Vector3f& viewpoint) {
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p(x[i], y[i], z[i]);
    with_plane(slot_of(voxel_index(p * inverse_resolution_)), viewpoint - p);
  }
}

void GaussianVoxelMap::remove_beyond(const Eigen::Vector3f& center, float radius, double fraction) {
  const auto edge = static_cast<float>(resolution_);
  table_.sweep(fraction, [&](VoxelKey key) {
    const Eigen::Vector3f middle =
        edge * (cell_of(key).cast<float>() + Eigen::Vector3f::Constant(0.5F));
    return (middle - center).squaredNorm() > radius * radius;
  });
}

Gaussian GaussianVoxelMap::gaussian_of(const VoxelSums& voxel) const {
  Gaussian result;
  result.count = voxel.count;
  const double n = voxel.count;
  const Eigen::Vector3d mean = Eigen::Vector3d(voxel.sum[0], voxel.sum[1], voxel.sum[2]) / n;
  const auto& s = voxel.products;
  const Eigen::Matrix3d scatter =
      symmetric(s[0], s[1], s[2], s[3], s[4], s[5]) - n * mean * mean.transpose();
  const Eigen::Vector3d center =
      resolution_ * (cell_of(voxel.key).cast<double>() + Eigen::Vector3d::Constant(0.5));
  result.mean = center + mean;
  result.covariance = scatter / std::max(1.0, n - 1.0);
  return result;
}

Gaussian GaussianVoxelMap::gaussian(const VoxelIndex& cell) const {
  const VoxelSums* const voxel = table_.find(slot_of(cell));
  return voxel != nullptr ? gaussian_of(*voxel) : Gaussian{};
}

std::vector<Gaussian> GaussianVoxelMap::gaussians() const {
  std::vector<const VoxelSums*> sorted;
  sorted.reserve(size());
  for (const VoxelSums& voxel : table_.slots()) {
    if (voxel.key != 0) sorted.push_back(&voxel);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const VoxelSums* a, const VoxelSums* b) { return a->key < b->key; });
  std::vector<Gaussian> result;
  result.reserve(sorted.size());
  for (const VoxelSums* voxel : sorted) result.push_back(gaussian_of(*voxel));
  return result;
}

/// From 0, where a voxel is crossed by several rings of a sensor in the direction `view`, to 1,
/// where it is crossed by one.
double GaussianVoxelMap::ring_isolation(const Eigen::Vector3f& view) const {
  const float distance = ring_spacing_ * view.norm() * inverse_resolution_;
  return std::clamp((distance - kSeveralRings) / (kOneRing - kSeveralRings), 0.0F, 1.0F);
}

void GaussianVoxelMap::update_plane(VoxelSums& voxel, double isolation) const {
  const bool has_side = voxel.count_at_plane == 0 || voxel.has_front != 0;
  const std::array<float, 3> front = voxel.normal;
  voxel.count_at_plane = voxel.count & 0x7FFFU;
  const Eigen::Vector3d normal = weighted_normal(gaussian_of(voxel), model_, isolation);
  const Eigen::Vector3d mean =
      Eigen::Vector3d(voxel.sum[0], voxel.sum[1], voxel.sum[2]) / static_cast<double>(voxel.count);
  const Eigen::Vector3f rounded = normal.cast<float>();
  voxel.normal = {rounded.x(), rounded.y(), rounded.z()};
  voxel.offset = static_cast<float>(normal.dot(mean));
  voxel.has_front = 0;
  if (has_side) turn_to_front(voxel, {front[0], front[1], front[2]});
}

/// The Gaussian with this key, its plane up to date; none if it has too few points.
VoxelSums* GaussianVoxelMap::with_plane(const VoxelTable::Slot& slot, const Eigen::Vector3f& view) {
  VoxelSums* const voxel = table_.find(slot);
  if (voxel == nullptr || voxel->count < model_.min_points) return nullptr;
  if (voxel->count * 100 > voxel->count_at_plane * kGrowthPercent) {
    update_plane(*voxel, ring_isolation(view));
  }
  return voxel;
}

WeightedPlane GaussianVoxelMap::plane(const VoxelIndex& cell, const VoxelTable::Slot& slot,
                                      const Eigen::Vector3f& view) {
  VoxelSums* voxel = with_plane(slot, view);
  if (voxel != nullptr && is_behind(*voxel, view)) {
    voxel = with_plane(table_.slot_of(slot.key | kBack), view);
  }
  if (voxel == nullptr) return {};
  const Eigen::Vector3f normal(voxel->normal[0], voxel->normal[1], voxel->normal[2]);
  const Eigen::Vector3f center =
      static_cast<float>(resolution_) * (cell.cast<float>() + Eigen::Vector3f::Constant(0.5F));
  return {normal, voxel->offset + normal.dot(center)};
}

}  // namespace lidar_mapping::registration
