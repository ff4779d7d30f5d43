// SPDX-License-Identifier: BSD-3-Clause
#include "scan/scan_sampler.hpp"

#include <algorithm>
#include <array>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/scattering_step.hpp"

#include "scan/hash_kernel.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Number of points for which hashes are computed at a time before they are looked up. Chosen: the
/// hashes (8 kB) stay in the first-level cache.
constexpr std::size_t kBlock = 2048;

float squared(double value) { return static_cast<float>(value * value); }

}  // namespace

ScanSampler::ScanSampler(int table_bits)
    : shift_(static_cast<std::uint32_t>(32 - table_bits)),
      last_generation_((std::size_t{1} << table_bits) + 1) {}

void ScanSampler::next_generation() {
  if (++generation_ == 0) {
    std::fill(last_generation_.begin(), last_generation_.end(), std::uint8_t{0});
    generation_ = 1;
  }
  // The entry for rejected points is always occupied.
  last_generation_.back() = generation_;
}

const std::vector<std::uint32_t>& ScanSampler::sample(const PointCloud& cloud,
                                                      const SamplingOptions& options) {
  next_generation();
  const HashKernel hash = hash_kernel();
  const HashRule rule{static_cast<float>(1.0 / options.resolution), squared(options.min_range),
                      squared(options.max_range), shift_,
                      static_cast<std::uint32_t>(last_generation_.size() - 1)};
  candidates_.resize(std::max(candidates_.size(), cloud.size() / options.stride + 1));
  // Local copies, because the compiler has to assume that a write of bytes may change any member.
  const std::size_t stride = options.stride;
  const std::uint8_t generation = generation_;
  std::uint8_t* const last_generation = last_generation_.data();
  std::uint32_t* const candidates = candidates_.data();
  std::size_t candidate_count = 0;
  std::array<std::uint32_t, kBlock> hashes;
  const std::size_t block = std::max<std::size_t>(1, kBlock / stride);
  const std::size_t step = options.scattered ? scattering_step(block) % block : 1;
  for (std::size_t begin = options.phase; begin < cloud.size(); begin += block * stride) {
    const std::size_t remaining = (cloud.size() - begin + stride - 1) / stride;
    const std::size_t count = std::min(remaining, block);
    hash(&cloud.points[begin].x, stride, count, rule, hashes.data());
    // The last block may have fewer points.
    for (std::size_t i = count; i < block; ++i) hashes[i] = rule.rejected;
    for (std::size_t visit = 0, i = 0; visit < block; ++visit) {
      // Without a branch: write always, and advance only if the cube is new.
      candidates[candidate_count] = static_cast<std::uint32_t>(begin + i * stride);
      candidate_count += static_cast<std::size_t>(last_generation[hashes[i]] != generation);
      last_generation[hashes[i]] = generation;
      i += step;
      i -= i >= block ? block : 0;
    }
  }
  chosen_.assign(candidates, candidates + candidate_count);
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

void SampledPoints::push_back(const Eigen::Vector3f& p, float time) {
  x.push_back(p.x());
  y.push_back(p.y());
  z.push_back(p.z());
  s.push_back(time);
}

void SampledPoints::remove(const PointMarks& marks) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    x[kept] = x[i];
    y[kept] = y[i];
    z[kept] = z[i];
    s[kept] = s[i];
    kept += marks[i] == 0 ? 1U : 0U;
  }
  for (auto* array : {&x, &y, &z, &s}) array->resize(kept);
}

void rotate_upwards(SampledPoints& points, double angle) {
  if (angle == 0.0) return;
  const ElevationShift shift(angle);
  for (std::size_t i = 0; i < points.size(); ++i) shift(points.x[i], points.y[i], points.z[i]);
}

}  // namespace lidar_mapping::front_end
