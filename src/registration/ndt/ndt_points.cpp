// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/ndt_points.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "ndt/ndt_kernels.hpp"

namespace lidar_mapping::registration {
namespace {

// Of a sweep: 6 ms at 10 Hz. Chosen: fewer blur fast turns, more fill up more lanes with nothing.
constexpr std::size_t kSlices = 16;
/// m. Chosen: outside of every map, because it is more than kMaxCellXY voxels of any size away.
/// Padding points lie there and have no plane.
constexpr float kFarAway = 1e6F;

}  // namespace

void NdtPoints::clear() {
  size_ = 0;
  for (auto* array : {&x_, &y_, &z_, &s_}) array->clear();
  slices_.clear();
}

void NdtPoints::push(float x, float y, float z, float s) {
  x_.push_back(x);
  y_.push_back(y);
  z_.push_back(z);
  s_.push_back(s);
}

void NdtPoints::close_slice(std::size_t begin) {
  const std::size_t count = x_.size() - begin;
  if (count == 0) return;
  double sum = 0.0;
  for (std::size_t i = begin; i < x_.size(); ++i) sum += s_[i];
  const auto mean = static_cast<float>(sum / static_cast<double>(count));
  while ((x_.size() - begin) % kNdtLanes != 0) push(kFarAway, kFarAway, kFarAway, 0.0F);
  size_ += count;
  slices_.push_back({begin, x_.size(), mean});
}

void NdtPoints::assign(const std::vector<float>& x, const std::vector<float>& y,
                       const std::vector<float>& z, const std::vector<float>& s,
                       const std::optional<Eigen::Vector3f>& viewpoint) {
  clear();
  viewpoint_ = viewpoint;
  if (x.empty()) return;
  const auto [first, last] = std::minmax_element(s.begin(), s.end());
  const float start = *first;
  const float scale = *last > start ? static_cast<float>(kSlices) / (*last - start) : 0.0F;
  const auto slice_of = [&](std::size_t i) {
    return std::min(static_cast<std::size_t>((s[i] - start) * scale), kSlices - 1);
  };
  // A counting sort that keeps the order within a slice.
  std::array<std::size_t, kSlices + 1> begin{};
  for (std::size_t i = 0; i < x.size(); ++i) ++begin[slice_of(i) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  order_.resize(x.size());
  auto next = begin;
  for (std::size_t i = 0; i < x.size(); ++i) order_[next[slice_of(i)]++] = i;
  for (std::size_t k = 0; k < kSlices; ++k) {
    const std::size_t slice_begin = x_.size();
    // After the sort next[k] stands at the end of slice k.
    for (std::size_t j = begin[k]; j < next[k]; ++j) {
      const std::size_t i = order_[j];
      push(x[i], y[i], z[i], s[i]);
    }
    close_slice(slice_begin);
  }
}

void NdtPoints::assign_thinned(const NdtPoints& points, std::size_t step) {
  clear();
  viewpoint_ = points.viewpoint_;
  std::size_t turn = 0;
  for (const Slice& slice : points.slices_) {
    const std::size_t begin = x_.size();
    for (std::size_t i = slice.begin; i < slice.end; ++i) {
      if (points.x_[i] == kFarAway || turn++ % step != 0) continue;
      push(points.x_[i], points.y_[i], points.z_[i], points.s_[i]);
    }
    close_slice(begin);
  }
}

}  // namespace lidar_mapping::registration
