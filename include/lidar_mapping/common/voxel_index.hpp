// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace lidar_mapping {

/// The greatest whole number that is not above `value`, which has to fit in the result. Without
/// std::floor, which is a call where the processor has no instruction for it.
inline int floor_to_int(float value) {
  const int whole = static_cast<int>(value);
  return whole - static_cast<int>(value < static_cast<float>(whole));
}
/// The greatest whole number that is not above `value`, for double.
inline std::int64_t floor_to_int(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return whole - static_cast<std::int64_t>(value < static_cast<double>(whole));
}

/// The greatest whole number that is not above the quotient of two whole numbers, of which the
/// divisor is positive. The operator / rounds towards zero instead.
template <typename Integer>
Integer floor_divided(Integer value, Integer divisor) {
  const Integer quotient = value / divisor;
  return value % divisor < 0 ? quotient - 1 : quotient;
}

/// Number of the voxel that a point lies in, along each axis.
using VoxelIndex = Eigen::Vector3i;

/// Index of the voxel that holds a point. `scaled`: the point in units of the voxel's edge, float
/// or double.
template <typename Derived>
VoxelIndex voxel_index(const Eigen::MatrixBase<Derived>& scaled) {
  EIGEN_STATIC_ASSERT_VECTOR_SPECIFIC_SIZE(Derived, 3)
  const auto floored = [&](int axis) { return static_cast<int>(floor_to_int(scaled[axis])); };
  return {floored(0), floored(1), floored(2)};
}

/// A voxel's index in one word: 21 bits for each axis, x above y above z, each with half of its
/// range added. So keys sort as indices do, a neighbour's key is a sum of steps, and bit 63 is
/// free. Indices beyond +-2^20 (at voxels of 1 cm beyond 10 km) come back from the other side.
using VoxelKey = std::uint64_t;

constexpr int kVoxelKeyBits = 21;  ///< of one axis, so that three axes fit into 64 bits
/// What is added to an index so that no key has a negative part: half of the range of its bits.
constexpr int kVoxelKeyHalf = 1 << (kVoxelKeyBits - 1);
/// The bits of one axis.
constexpr VoxelKey kVoxelKeyMask = (VoxelKey{1} << kVoxelKeyBits) - 1;
/// From a voxel's key to that of the next voxel along x.
constexpr VoxelKey kVoxelKeyStepX = VoxelKey{1} << (2 * kVoxelKeyBits);
/// From a voxel's key to that of the next voxel along y.
constexpr VoxelKey kVoxelKeyStepY = VoxelKey{1} << kVoxelKeyBits;
/// From a voxel's key to that of the next voxel along z.
constexpr VoxelKey kVoxelKeyStepZ = 1;

/// The key of a voxel.
inline VoxelKey voxel_key(const VoxelIndex& index) {
  const auto bits = [](int number) {
    return static_cast<VoxelKey>(static_cast<std::uint32_t>(number) + kVoxelKeyHalf) &
           kVoxelKeyMask;
  };
  return bits(index.x()) * kVoxelKeyStepX | bits(index.y()) * kVoxelKeyStepY | bits(index.z());
}

/// The index of a voxel, from its key.
inline VoxelIndex voxel_index(VoxelKey key) {
  const auto number = [](VoxelKey bits) {
    return static_cast<int>(bits & kVoxelKeyMask) - kVoxelKeyHalf;
  };
  return {number(key >> (2 * kVoxelKeyBits)), number(key >> kVoxelKeyBits), number(key)};
}

/// The key of a square in a horizontal grid: 32 bits for each number. Squares whose numbers are
/// multiples of 2^32 apart share their key.
inline std::uint64_t square_key(std::int64_t column, std::int64_t row) {
  return std::uint64_t{static_cast<std::uint32_t>(column)} << 32U | static_cast<std::uint32_t>(row);
}

/// Calls `act(key)` for the voxel and its 26 neighbours, in the order of their keys.
template <typename Act>
void for_voxels_around(VoxelKey key, const Act& act) {
  for (const VoxelKey x : {key - kVoxelKeyStepX, key, key + kVoxelKeyStepX}) {
    for (const VoxelKey y : {x - kVoxelKeyStepY, x, x + kVoxelKeyStepY}) {
      for (const VoxelKey z : {y - kVoxelKeyStepZ, y, y + kVoxelKeyStepZ}) act(z);
    }
  }
}

/// Spreads keys over 64 bits, of which the upper ones are the best (Fibonacci hashing, Knuth 1998,
/// The Art of Computer Programming 3, 6.4).
inline std::uint64_t fibonacci_hash(std::uint64_t key) { return key * 0x9E3779B97F4A7C15ULL; }

/// Hash of a key for tables that look at the lower bits. Those of x lie high in a key, where
/// multiplying moves them out of the word: they are folded down first.
struct VoxelKeyHash {
  /// 32 well-mixed bits, the best of them uppermost.
  std::size_t operator()(VoxelKey key) const {
    return static_cast<std::size_t>(fibonacci_hash(key ^ (key >> 31U)) >> 32U);
  }
};

}  // namespace lidar_mapping
