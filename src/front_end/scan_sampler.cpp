#include "lidar_mapping/front_end/scan_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::front_end {
namespace {

std::uint32_t hash_of(const Point& point, float inverse_resolution) {
  const auto cell = [&](float coordinate) {
    return static_cast<std::uint32_t>(
        static_cast<std::int32_t>(std::floor(coordinate * inverse_resolution)));
  };
  return (cell(point.x) * 0x9E3779B1U) ^ (cell(point.y) * 0x85EBCA77U) ^
         (cell(point.z) * 0xC2B2AE3DU);
}

}  // namespace

void SampledPoints::clear() {
  for (auto* array : {&x, &y, &z, &s}) array->clear();
}

void SampledPoints::push(const Point& point, float time) {
  x.push_back(point.x);
  y.push_back(point.y);
  z.push_back(point.z);
  s.push_back(time);
}

ScanSampler::ScanSampler(int table_bits)
    : shift_(static_cast<std::uint32_t>(32 - table_bits)), taken_(std::size_t{1} << table_bits) {}

void ScanSampler::next_generation() {
  if (++generation_ != 0) return;
  std::fill(taken_.begin(), taken_.end(), std::uint8_t{0});
  generation_ = 1;
}

void ScanSampler::sample(const PointCloud& cloud, const SamplingOptions& options,
                         SampledPoints& result) {
  next_generation();
  result.clear();
  const auto inverse = static_cast<float>(1.0 / options.resolution);
  const auto nearest = static_cast<float>(options.min_range * options.min_range);
  const auto farthest = static_cast<float>(options.max_range * options.max_range);
  for (std::size_t i = options.phase; i < cloud.size(); i += options.stride) {
    const Point& point = cloud.points[i];
    const float range = point.x * point.x + point.y * point.y + point.z * point.z;
    // Written so that NaN fails.
    if (!(range > nearest && range < farthest)) continue;
    std::uint8_t& mark = taken_[(hash_of(point, inverse) * 0x9E3779B1U) >> shift_];
    if (mark == generation_) continue;
    mark = generation_;
    result.push(point, cloud.has_times() ? cloud.times[i] : 0.0F);
  }
}

}  // namespace lidar_mapping::front_end
