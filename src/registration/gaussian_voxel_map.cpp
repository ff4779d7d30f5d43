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

/// Parts coordinates into the number of the voxel and the distance from its middle. Without
/// std::floor, which is a call where the processor has no instruction for it.
void split(const float* values, std::size_t count, float inverse_resolution, float resolution,
           int* cells, float* offsets) {
  for (std::size_t i = 0; i < count; ++i) {
    const float scaled = inverse_resolution * values[i];
    const int truncated = static_cast<int>(scaled);
    const int lower = truncated - static_cast<int>(static_cast<float>(truncated) > scaled);
    cells[i] = lower;
    offsets[i] = resolution * (scaled - static_cast<float>(lower) - 0.5F);
  }
}

/// From 0 at `none` to 1 at `all`.
double ramp(double value, double none, double all) {
  return std::clamp((value - none) / (all - none), 0.0, 1.0);
}

}  // namespace

GaussianVoxelMap::GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model)
    : resolution_(resolution),
      inverse_resolution_(static_cast<float>(1.0 / resolution)),
      model_(model),
      voxels_(next_power_of_two(capacity)) {
  mask_ = static_cast<std::uint32_t>(voxels_.size() - 1);
  most_voxels_ = static_cast<std::size_t>(kMaxLoad * static_cast<double>(voxels_.size()));
  hash_shift_ = 64;
  for (std::size_t slots = voxels_.size(); slots > 1; slots /= 2) --hash_shift_;
}

void GaussianVoxelMap::clear() {
  if (size_ > 0) std::fill(voxels_.begin(), voxels_.end(), Voxel{});
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

GaussianVoxelMap::Voxel* GaussianVoxelMap::find_or_add(std::uint64_t key, std::uint32_t hint) {
  for (std::uint32_t slot = hint;; slot = (slot + 1) & mask_) {
    Voxel& voxel = voxels_[slot];
    if (voxel.key == key) return &voxel;
    if (voxel.key != 0) continue;
    if (size_ >= most_voxels_) return nullptr;
    voxel.key = key;
    ++size_;
    return &voxel;
  }
}

/// `p` is relative to the voxel's centre.
void GaussianVoxelMap::add_point(std::uint64_t key, std::uint32_t hint, float px, float py,
                                 float pz) {
  Voxel* voxel = find_or_add(key, hint);
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

void GaussianVoxelMap::insert(const float* x, const float* y, const float* z, std::size_t count) {
  constexpr std::size_t kBlock = 64;
  const float* const coordinates[3] = {x, y, z};
  int cells[3][kBlock];
  float offsets[3][kBlock];
  std::uint64_t keys[kBlock];
  std::uint32_t slots[kBlock];
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(kBlock, count - begin);
    for (int axis = 0; axis < 3; ++axis) {
      split(coordinates[axis] + begin, size, inverse_resolution_, static_cast<float>(resolution_),
            cells[axis], offsets[axis]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      keys[i] = key_of({cells[0][i], cells[1][i], cells[2][i]});
      slots[i] = slot_of(keys[i]);
      prefetch(slots[i]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      add_point(keys[i], slots[i], offsets[0][i], offsets[1][i], offsets[2][i]);
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
  const double trust = ramp(roundness, model_.line_floor, model_.line_ratio) *
                       ramp(std::sqrt(values[1]), model_.least_breadth, model_.sure_breadth);
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
