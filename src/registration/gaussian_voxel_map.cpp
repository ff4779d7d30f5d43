#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::registration {
namespace {

constexpr int kCoordinateBits = 21;
constexpr int kCoordinateOffset = 1 << (kCoordinateBits - 1);
constexpr std::uint64_t kCoordinateMask = (1U << kCoordinateBits) - 1U;
constexpr std::uint16_t kMaxCount = std::numeric_limits<std::uint16_t>::max();
/// Linear probing stays short up to this load.
constexpr double kMaxLoad = 0.75;
/// A plane is computed again when its voxel has grown by this factor.
constexpr int kGrowthPercent = 110;

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

}  // namespace

GaussianVoxelMap::GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model)
    : resolution_(resolution),
      inverse_resolution_(static_cast<float>(1.0 / resolution)),
      model_(model),
      voxels_(next_power_of_two(capacity)) {
  mask_ = static_cast<std::uint32_t>(voxels_.size() - 1);
  hash_shift_ = 64;
  for (std::size_t slots = voxels_.size(); slots > 1; slots /= 2) --hash_shift_;
}

void GaussianVoxelMap::clear() {
  std::fill(voxels_.begin(), voxels_.end(), Voxel{});
  size_ = 0;
  hand_ = 0;
  dropped_points_ = 0;
}

std::uint64_t GaussianVoxelMap::key_of(const Eigen::Vector3i& cell) const {
  const auto part = [&](int axis) {
    return static_cast<std::uint64_t>(cell[axis] + origin_cell_[axis] + kCoordinateOffset) &
           kCoordinateMask;
  };
  return (part(0) << (2 * kCoordinateBits)) | (part(1) << kCoordinateBits) | part(2);
}

Eigen::Vector3i GaussianVoxelMap::cell_of(std::uint64_t key) const {
  const auto part = [&](int shift) {
    return static_cast<int>((key >> shift) & kCoordinateMask) - kCoordinateOffset;
  };
  return Eigen::Vector3i(part(2 * kCoordinateBits), part(kCoordinateBits), part(0)) - origin_cell_;
}

std::uint32_t GaussianVoxelMap::slot_of(std::uint64_t key) const {
  return static_cast<std::uint32_t>((key * 0x9E3779B97F4A7C15ULL) >> hash_shift_);
}

std::optional<std::uint32_t> GaussianVoxelMap::find(std::uint64_t key, std::uint32_t hint) const {
  for (std::uint32_t slot = hint; voxels_[slot].key != 0; slot = (slot + 1) & mask_) {
    if (voxels_[slot].key == key) return slot;
  }
  return std::nullopt;
}

GaussianVoxelMap::Voxel* GaussianVoxelMap::find_or_add(std::uint64_t key) {
  for (std::uint32_t slot = slot_of(key);; slot = (slot + 1) & mask_) {
    Voxel& voxel = voxels_[slot];
    if (voxel.key == key) return &voxel;
    if (voxel.key != 0) continue;
    if (static_cast<double>(size_) >= kMaxLoad * static_cast<double>(voxels_.size()))
      return nullptr;
    voxel.key = key;
    ++size_;
    return &voxel;
  }
}

void GaussianVoxelMap::add_point(float x, float y, float z) {
  const Eigen::Vector3f scaled = inverse_resolution_ * Eigen::Vector3f(x, y, z);
  const Eigen::Vector3f lower = scaled.array().floor();
  Voxel* voxel = find_or_add(key_of(lower.cast<int>()));
  if (voxel == nullptr) {
    ++dropped_points_;
    return;
  }
  // A full voxel is a good anchor as it is.
  if (voxel->count == kMaxCount) return;
  const Eigen::Vector3f p =
      static_cast<float>(resolution_) * (scaled - lower - Eigen::Vector3f::Constant(0.5F));
  ++voxel->count;
  for (std::size_t axis = 0; axis < 3; ++axis) voxel->sum[axis] += p[static_cast<int>(axis)];
  voxel->products[0] += p.x() * p.x();
  voxel->products[1] += p.x() * p.y();
  voxel->products[2] += p.x() * p.z();
  voxel->products[3] += p.y() * p.y();
  voxel->products[4] += p.y() * p.z();
  voxel->products[5] += p.z() * p.z();
}

void GaussianVoxelMap::insert(const float* x, const float* y, const float* z, std::size_t count) {
  constexpr std::size_t kAhead = 16;
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) {
      const std::size_t j = i + kAhead;
      const Eigen::Vector3f scaled = inverse_resolution_ * Eigen::Vector3f(x[j], y[j], z[j]);
      prefetch(slot_hint(scaled.array().floor().cast<int>()));
    }
    add_point(x[i], y[i], z[i]);
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
  const auto slot = find(key_of(cell), slot_hint(cell));
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

/// The thinnest axis of the Gaussian, after the weak prior of the model; distrusted where the
/// points lie on a line, because then the axis is arbitrary around it.
void GaussianVoxelMap::update_plane(Voxel& voxel) const {
  voxel.count_at_plane = voxel.count;
  const Gaussian gaussian = gaussian_of(voxel);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(gaussian.covariance);
  const Eigen::Vector3d values = solver.eigenvalues().cwiseMax(0.0);
  const double free = gaussian.count - 1.0;
  const double prior = model_.prior_points;
  const double variance =
      (free * values[0] + prior * model_.prior_sigma * model_.prior_sigma) / (free + prior) +
      model_.sigma * model_.sigma;
  const double roundness = values[2] > 0.0 ? values[1] / values[2] : 0.0;
  const double trust = std::clamp(
      (roundness - model_.line_floor) / (model_.line_ratio - model_.line_floor), 0.0, 1.0);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0) * (trust / std::sqrt(variance));
  const Eigen::Vector3d mean =
      Eigen::Vector3d(voxel.sum[0], voxel.sum[1], voxel.sum[2]) / static_cast<double>(voxel.count);
  for (int axis = 0; axis < 3; ++axis) {
    voxel.normal[static_cast<std::size_t>(axis)] = static_cast<float>(normal[axis]);
  }
  voxel.offset = static_cast<float>(normal.dot(mean));
}

WeightedPlane GaussianVoxelMap::plane(const Eigen::Vector3i& cell, std::uint32_t hint) {
  const auto slot = find(key_of(cell), hint);
  if (!slot || voxels_[*slot].count < model_.min_points) return {};
  Voxel& voxel = voxels_[*slot];
  if (voxel.count * 100 > voxel.count_at_plane * kGrowthPercent) update_plane(voxel);
  const Eigen::Vector3f normal(voxel.normal[0], voxel.normal[1], voxel.normal[2]);
  const Eigen::Vector3f center =
      static_cast<float>(resolution_) * (cell.cast<float>() + Eigen::Vector3f::Constant(0.5F));
  return {normal, voxel.offset + normal.dot(center)};
}

}  // namespace lidar_mapping::registration
