// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/voxel_index.hpp"

#include "weighted_normal.hpp"

namespace lidar_mapping::registration {
namespace {

/// Marks the Gaussian of the side of a voxel's plane that was seen second.
constexpr VoxelKey kBack = VoxelKey{1} << (3 * kVoxelKeyBits);
constexpr std::uint16_t kMaxCount = std::numeric_limits<std::int16_t>::max();
// A plane has two sides if it is thin (m). A view along it, below this sine of the angle, tells
// nothing about the side.
constexpr float kThinSurface = 0.05F;
constexpr float kLeastSlope = 0.03F;
/// Linear probing stays short up to this load.
constexpr double kMaxLoad = 0.75;
/// Up to this share of the table its slots are cleared one by one.
constexpr double kListedShare = 0.25;
/// A plane is computed again when its voxel has grown by this factor.
constexpr int kGrowthPercent = 110;
// Distance of rings in edges of the voxel: up to this it is crossed by several at a time, from this
// on by one.
constexpr float kSeveralRings = 0.75F;
constexpr float kOneRing = 1.25F;

std::size_t next_power_of_two(std::size_t value) {
  std::size_t power = 16;
  while (power < value) power *= 2;
  return power;
}

Eigen::Matrix3d symmetric(double xx, double xy, double xz, double yy, double yz, double zz) {
  Eigen::Matrix3d matrix;
  matrix << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return matrix;
}

/// Parts coordinates into the number of the voxel and the distance from its middle.
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

/// True if `view` is steep enough on the plane for it to be seen from one side.
bool tells_side(const std::array<float, 3>& normal, const Eigen::Vector3f& view, float along) {
  const Eigen::Vector3f n(normal[0], normal[1], normal[2]);
  return along * along > kLeastSlope * kLeastSlope * n.squaredNorm() * view.squaredNorm();
}

}  // namespace

GaussianVoxelMap::GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model)
    : resolution_(resolution),
      inverse_resolution_(static_cast<float>(1.0 / resolution)),
      model_(model),
      voxels_(next_power_of_two(capacity)) {
  mask_ = static_cast<std::uint32_t>(voxels_.size() - 1);
  most_voxels_ = static_cast<std::size_t>(kMaxLoad * static_cast<double>(voxels_.size()));
  most_listed_ = static_cast<std::size_t>(kListedShare * static_cast<double>(voxels_.size()));
  hash_shift_ = 64;
  for (std::size_t slots = voxels_.size(); slots > 1; slots /= 2) --hash_shift_;
}

/// A map of one scan is cleared several times at the start of a drive: by its own voxels, not by
/// the whole table.
void GaussianVoxelMap::clear() {
  if (used_.size() < most_listed_) {
    for (const std::uint32_t slot : used_) voxels_[slot] = Voxel{};
  } else {
    std::fill(voxels_.begin(), voxels_.end(), Voxel{});
  }
  used_.clear();
  size_ = 0;
  hand_ = 0;
  dropped_points_ = 0;
}

void GaussianVoxelMap::restart(double resolution) {
  clear();
  resolution_ = resolution;
  inverse_resolution_ = static_cast<float>(1.0 / resolution);
  origin_cell_.setZero();
}

VoxelKey GaussianVoxelMap::key_of(const VoxelIndex& cell) const {
  return voxel_key(cell + origin_cell_);
}

VoxelIndex GaussianVoxelMap::cell_of(VoxelKey key) const { return voxel_index(key) - origin_cell_; }

std::optional<std::uint32_t> GaussianVoxelMap::find(const Place& place) const {
  for (std::uint32_t slot = place.slot; voxels_[slot].key != 0; slot = (slot + 1) & mask_) {
    if (voxels_[slot].key == place.key) return slot;
  }
  return std::nullopt;
}

GaussianVoxelMap::Voxel* GaussianVoxelMap::find_or_add(const Place& place) {
  for (std::uint32_t slot = place.slot;; slot = (slot + 1) & mask_) {
    Voxel& voxel = voxels_[slot];
    if (voxel.key == place.key) return &voxel;
    if (voxel.key != 0) continue;
    if (size_ >= most_voxels_) return nullptr;
    voxel.key = place.key;
    if (used_.size() < most_listed_) used_.push_back(slot);
    ++size_;
    return &voxel;
  }
}

/// The Gaussian that a point belongs to from which the sensor lies in the direction `view`.
GaussianVoxelMap::Voxel* GaussianVoxelMap::side_seen(const Place& place,
                                                     const Eigen::Vector3f& view) {
  Voxel* const voxel = find_or_add(place);
  if (voxel == nullptr) return nullptr;
  if (voxel->count_at_plane == 0) {
    for (int axis = 0; axis < 3; ++axis) {
      voxel->normal[static_cast<std::size_t>(axis)] = view[axis];
    }
    return voxel;
  }
  if (voxel->has_front == 0) {
    turn_to_front(*voxel, view);
  } else if (is_behind(*voxel, view) && (place.key & kBack) == 0) {
    return side_seen(place_of(place.key | kBack), view);
  }
  return voxel;
}

/// Lets the normal of a voxel point to the side from which it is seen.
void GaussianVoxelMap::turn_to_front(Voxel& voxel, const Eigen::Vector3f& view) {
  const float along = dot(voxel.normal, view);
  if (!tells_side(voxel.normal, view, along)) return;
  voxel.has_front = 1;
  if (along > 0.0F) return;
  for (float& value : voxel.normal) value = -value;
  voxel.offset = -voxel.offset;
}

/// True if the sensor sees the plane's other side.
bool GaussianVoxelMap::is_behind(const Voxel& voxel, const Eigen::Vector3f& view) {
  if (voxel.has_front == 0) return false;
  const float along = dot(voxel.normal, view);
  if (along >= 0.0F) return false;
  const auto& n = voxel.normal;
  const float sharpness = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  return sharpness > 1.0F / (kThinSurface * kThinSurface) && tells_side(n, view, along);
}

/// `p` is relative to the voxel's centre.
void GaussianVoxelMap::add_point(Voxel* voxel, float px, float py, float pz) {
  if (voxel == nullptr) {
    ++dropped_points_;
    return;
  }
  // A full voxel is a good anchor as it is.
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
  Place places[kBlock];
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(kBlock, count - begin);
    for (int axis = 0; axis < 3; ++axis) {
      split(coordinates[axis] + begin, size, inverse_resolution_, static_cast<float>(resolution_),
            cells[axis], offsets[axis]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      places[i] = place_of(Eigen::Vector3i(cells[0][i], cells[1][i], cells[2][i]));
      prefetch(places[i]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t p = begin + i;
      Voxel* const voxel =
          viewpoint ? side_seen(places[i], *viewpoint - Eigen::Vector3f(x[p], y[p], z[p]))
                    : find_or_add(places[i]);
      add_point(voxel, offsets[0][i], offsets[1][i], offsets[2][i]);
    }
  }
}

void GaussianVoxelMap::forget_beyond(const Eigen::Vector3f& center, float radius, double share) {
  const auto steps = static_cast<std::size_t>(share * static_cast<double>(voxels_.size()));
  const auto edge = static_cast<float>(resolution_);
  for (std::size_t step = 0; step < steps; ++step) {
    const Voxel& voxel = voxels_[hand_];
    if (voxel.key != 0) {
      const Eigen::Vector3f middle =
          edge * (cell_of(voxel.key).cast<float>() + Eigen::Vector3f::Constant(0.5F));
      if ((middle - center).squaredNorm() > radius * radius) {
        erase(hand_);
        continue;  // another voxel may have moved into this slot
      }
    }
    hand_ = (hand_ + 1) & mask_;
  }
}

/// Closes the gap by moving later voxels of the same run back, so that no tombstones are needed.
void GaussianVoxelMap::erase(std::uint32_t slot) {
  std::uint32_t gap = slot;
  for (std::uint32_t next = (gap + 1) & mask_; voxels_[next].key != 0; next = (next + 1) & mask_) {
    const std::uint32_t home = slot_of(voxels_[next].key);
    if (((next - home) & mask_) >= ((next - gap) & mask_)) {
      voxels_[gap] = voxels_[next];
      gap = next;
    }
  }
  voxels_[gap] = Voxel{};
  --size_;
}

Gaussian GaussianVoxelMap::gaussian_of(const Voxel& voxel) const {
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

Gaussian GaussianVoxelMap::gaussian(const Eigen::Vector3i& cell) const {
  const auto slot = find(place_of(cell));
  return slot ? gaussian_of(voxels_[*slot]) : Gaussian{};
}

std::vector<Gaussian> GaussianVoxelMap::gaussians() const {
  std::vector<const Voxel*> sorted;
  sorted.reserve(size_);
  for (const Voxel& voxel : voxels_) {
    if (voxel.key != 0) sorted.push_back(&voxel);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Voxel* a, const Voxel* b) { return a->key < b->key; });
  std::vector<Gaussian> result;
  result.reserve(sorted.size());
  for (const Voxel* voxel : sorted) result.push_back(gaussian_of(*voxel));
  return result;
}

/// How far rings seen from there cross a voxel one by one, 0 to 1.
double GaussianVoxelMap::loneliness(const Eigen::Vector3f& view) const {
  const float distance = ring_spacing_ * view.norm() * inverse_resolution_;
  return std::clamp((distance - kSeveralRings) / (kOneRing - kSeveralRings), 0.0F, 1.0F);
}

void GaussianVoxelMap::update_plane(Voxel& voxel, double lone_rings) const {
  const bool has_side = voxel.count_at_plane == 0 || voxel.has_front != 0;
  const std::array<float, 3> front = voxel.normal;
  voxel.count_at_plane = voxel.count & 0x7FFFU;
  const Eigen::Vector3d normal = weighted_normal(gaussian_of(voxel), model_, lone_rings);
  const Eigen::Vector3d mean =
      Eigen::Vector3d(voxel.sum[0], voxel.sum[1], voxel.sum[2]) / static_cast<double>(voxel.count);
  for (int axis = 0; axis < 3; ++axis) {
    voxel.normal[static_cast<std::size_t>(axis)] = static_cast<float>(normal[axis]);
  }
  voxel.offset = static_cast<float>(normal.dot(mean));
  voxel.has_front = 0;
  if (has_side) turn_to_front(voxel, {front[0], front[1], front[2]});
}

/// The Gaussian with this key, its plane up to date; none if it has too few points.
GaussianVoxelMap::Voxel* GaussianVoxelMap::with_plane(const Place& place,
                                                      const Eigen::Vector3f& view) {
  const auto slot = find(place);
  if (!slot || voxels_[*slot].count < model_.min_points) return nullptr;
  Voxel& voxel = voxels_[*slot];
  if (voxel.count * 100 > voxel.count_at_plane * kGrowthPercent)
    update_plane(voxel, loneliness(view));
  return &voxel;
}

WeightedPlane GaussianVoxelMap::plane(const Eigen::Vector3i& cell, const Place& place,
                                      const Eigen::Vector3f& view) {
  Voxel* voxel = with_plane(place, view);
  if (voxel != nullptr && is_behind(*voxel, view)) {
    voxel = with_plane(place_of(place.key | kBack), view);
  }
  if (voxel == nullptr) return {};
  const Eigen::Vector3f normal(voxel->normal[0], voxel->normal[1], voxel->normal[2]);
  const Eigen::Vector3f center =
      static_cast<float>(resolution_) * (cell.cast<float>() + Eigen::Vector3f::Constant(0.5F));
  return {normal, voxel->offset + normal.dot(center)};
}

}  // namespace lidar_mapping::registration
