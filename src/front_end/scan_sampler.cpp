#include "lidar_mapping/front_end/scan_sampler.hpp"

#include <algorithm>
#include <array>

namespace lidar_mapping::front_end {
namespace {

/// Hashes are computed for so many points at a time: the loop has no branches and is vectorised.
constexpr std::size_t kBlock = 256;
/// Stands for a point that is out of range or not finite.
constexpr std::uint32_t kNoHash = 0xFFFFFFFFU;

struct HashRule {
  float inverse_resolution;
  float min_range_squared;
  float max_range_squared;
  std::uint32_t shift;
};

inline std::uint32_t cell(float coordinate) {
  const auto truncated = static_cast<std::int32_t>(coordinate);
  return static_cast<std::uint32_t>(truncated -
                                    static_cast<int>(static_cast<float>(truncated) > coordinate));
}

void hash_block(const Point* points, std::size_t stride, std::size_t count, const HashRule& rule,
                std::uint32_t* hashes) {
  for (std::size_t i = 0; i < count; ++i) {
    const Point& p = points[i * stride];
    const float range = p.x * p.x + p.y * p.y + p.z * p.z;
    // Written so that NaN fails.
    const bool usable = range >= rule.min_range_squared && range < rule.max_range_squared;
    const float scale = rule.inverse_resolution;
    const std::uint32_t mixed = (cell(usable ? p.x * scale : 0.0F) * 0x9E3779B1U) ^
                                (cell(usable ? p.y * scale : 0.0F) * 0x85EBCA77U) ^
                                (cell(usable ? p.z * scale : 0.0F) * 0xC2B2AE3DU);
    hashes[i] = usable ? (mixed * 0x27D4EB2FU) >> rule.shift : kNoHash;
  }
}

float squared(double value) { return static_cast<float>(value * value); }

}  // namespace

ScanSampler::ScanSampler(int table_bits)
    : shift_(static_cast<std::uint32_t>(32 - table_bits)), taken_(std::size_t{1} << table_bits) {}

void ScanSampler::next_generation() {
  if (++generation_ != 0) return;
  std::fill(taken_.begin(), taken_.end(), std::uint8_t{0});
  generation_ = 1;
}

const std::vector<std::uint32_t>& ScanSampler::sample(const PointCloud& cloud,
                                                      const SamplingOptions& options) {
  next_generation();
  chosen_.clear();
  const HashRule rule{static_cast<float>(1.0 / options.resolution), squared(options.min_range),
                      squared(options.max_range), shift_};
  std::array<std::uint32_t, kBlock> hashes;
  for (std::size_t begin = options.phase; begin < cloud.size(); begin += kBlock * options.stride) {
    const std::size_t left = (cloud.size() - begin + options.stride - 1) / options.stride;
    const std::size_t count = std::min(left, kBlock);
    hash_block(&cloud.points[begin], options.stride, count, rule, hashes.data());
    for (std::size_t i = 0; i < count; ++i) {
      if (hashes[i] == kNoHash || taken_[hashes[i]] == generation_) continue;
      taken_[hashes[i]] = generation_;
      chosen_.push_back(static_cast<std::uint32_t>(begin + i * options.stride));
    }
  }
  return chosen_;
}

void SampledPoints::assign(const PointCloud& cloud, const std::vector<std::uint32_t>& indices,
                           double reference) {
  for (auto* array : {&x, &y, &z, &s}) array->resize(indices.size());
  const auto offset = static_cast<float>(reference);
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const Point& point = cloud.points[indices[k]];
    x[k] = point.x;
    y[k] = point.y;
    z[k] = point.z;
    s[k] = cloud.has_times() ? cloud.times[indices[k]] - offset : 0.0F;
  }
}

}  // namespace lidar_mapping::front_end
