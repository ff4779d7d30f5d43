#include "lidar_mapping/front_end/sweep_sampler.hpp"

#include <algorithm>

namespace lidar_mapping::front_end {
namespace {

/// Nearer points see the vehicle itself.
constexpr double kMinRange = 1.0;
/// So many points are looked at for the match; more would cost time and bring nothing.
constexpr std::size_t kCandidates = 16000;
constexpr int kSparseTableBits = 15;
constexpr int kDenseTableBits = 17;

/// Odd, so that it visits all rings of a cloud that is stored firing by firing.
std::size_t stride_for(std::size_t points) { return (points / kCandidates) | 1U; }

double middle_time(const PointCloud& cloud, const std::vector<std::uint32_t>& indices) {
  if (!cloud.has_times() || indices.empty()) return 0.0;
  float first = cloud.times[indices.front()];
  float last = first;
  for (const std::uint32_t i : indices) {
    first = std::min(first, cloud.times[i]);
    last = std::max(last, cloud.times[i]);
  }
  return 0.5 * (static_cast<double>(first) + static_cast<double>(last));
}

}  // namespace

SweepSampler::SweepSampler(const FrontEndConfig& config)
    : scan_resolution_(config.scan_resolution),
      insertion_resolution_(config.insertion_resolution),
      max_range_(config.max_range),
      sparse_sampler_(kSparseTableBits),
      dense_sampler_(kDenseTableBits) {}

void SweepSampler::take(const Scan& scan, std::size_t turn) {
  const std::size_t stride = stride_for(scan.cloud.size());
  const auto& indices = sparse_sampler_.sample(
      scan.cloud, {scan_resolution_, kMinRange, max_range_, stride, turn % stride});
  reference_ = middle_time(scan.cloud, indices);
  sparse_.assign(scan.cloud, indices, reference_);
  points_.assign(sparse_.x, sparse_.y, sparse_.z, sparse_.s);
}

const SampledPoints& SweepSampler::dense(const Scan& scan) {
  const auto& indices =
      dense_sampler_.sample(scan.cloud, {insertion_resolution_, kMinRange, max_range_, 1, 0});
  dense_.assign(scan.cloud, indices, reference_);
  return dense_;
}

}  // namespace lidar_mapping::front_end
