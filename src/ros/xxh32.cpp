#include "xxh32.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace lidar_mapping::ros_border {

namespace {

// The names of the specification.
constexpr std::uint32_t kPrime1 = 0x9E3779B1, kPrime2 = 0x85EBCA77, kPrime3 = 0xC2B2AE3D,
                        kPrime4 = 0x27D4EB2F, kPrime5 = 0x165667B1;
constexpr std::size_t kStripe = 16, kLane = 4;  // bytes
constexpr std::size_t kBlock = 64;              // lanes

std::uint32_t rotated(std::uint32_t value, int bits) {
  return (value << bits) | (value >> (32 - bits));
}

std::uint32_t lane_at(const std::uint8_t* from) {
  std::uint32_t lane;
  std::memcpy(&lane, from, sizeof(lane));
  return lane;
}

std::uint32_t mixed(std::uint32_t accumulator, std::uint64_t product) {
  return rotated(accumulator + static_cast<std::uint32_t>(product), 13) * kPrime1;
}

/// Of whole stripes of four lanes. Lanes are multiplied many at a time, of which compilers make
/// vectors: multiplications are what takes long.
std::uint32_t converged(const std::uint8_t* from, const std::uint8_t* end) {
  std::uint32_t a = kPrime1 + kPrime2, b = kPrime2, c = 0, d = 0 - kPrime1;
  std::array<std::uint64_t, kBlock> products;
  while (from != end) {
    const std::size_t lanes = std::min(kBlock, static_cast<std::size_t>(end - from) / kLane);
    for (std::size_t i = 0; i < lanes; ++i) {
      products[i] = static_cast<std::uint64_t>(lane_at(from + i * kLane)) * kPrime2;
    }
    for (std::size_t i = 0; i < lanes; i += kStripe / kLane) {
      a = mixed(a, products[i]);
      b = mixed(b, products[i + 1]);
      c = mixed(c, products[i + 2]);
      d = mixed(d, products[i + 3]);
    }
    from += lanes * kLane;
  }
  return rotated(a, 1) + rotated(b, 7) + rotated(c, 12) + rotated(d, 18);
}

std::uint32_t avalanched(std::uint32_t hash) {
  hash = (hash ^ (hash >> 15)) * kPrime2;
  hash = (hash ^ (hash >> 13)) * kPrime3;
  return hash ^ (hash >> 16);
}

}  // namespace

std::uint32_t xxh32(ByteRange data) {
  const std::uint8_t* from = data.first + data.size / kStripe * kStripe;
  const std::uint8_t* const end = data.first + data.size;
  std::uint32_t hash = data.size < kStripe ? kPrime5 : converged(data.first, from);
  hash += static_cast<std::uint32_t>(data.size);
  for (; end - from >= static_cast<std::ptrdiff_t>(kLane); from += kLane) {
    hash = rotated(hash + lane_at(from) * kPrime3, 17) * kPrime4;
  }
  for (; from != end; ++from) hash = rotated(hash + *from * kPrime5, 11) * kPrime1;
  return avalanched(hash);
}

}  // namespace lidar_mapping::ros_border
