// SPDX-License-Identifier: BSD-3-Clause
#include "scan/sweep_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/order_statistics.hpp"

#include "scan/sweep_order.hpp"

namespace lidar_mapping::front_end {
namespace {

/// m. Nearer points belong to the vehicle itself; chosen: so far a car's roof reaches from the
/// sensor.
constexpr double kMinRange = 1.0;
/// Number of points from which those for the match are sampled. Measured (doc/results/ablation.md):
/// twice as many change nothing, with half as many errors are 1.14 times as large.
constexpr std::size_t kMaxCandidates = 16000;
/// Cells are made smaller until they give about this number of points. Measured at half and twice,
/// as is kMinCellFraction: some drives gain, others lose (doc/results/ablation.md).
constexpr double kWantedMatchedPoints = 2500.0;
constexpr double kWantedInsertedPoints = 12000.0;
/// They are not made smaller than this fraction of the configured edge. Measured: at half of it
/// errors are 0.83 times as large, but probabilities are less true; at twice 1.65 times.
constexpr double kMinCellFraction = 0.4;
// Slots of the tables of hashes. Chosen: so many that a collision, which drops a point, happens to
// less than one in ten wanted points.
constexpr int kSparseTableBits = 15;
constexpr int kDenseTableBits = 17;

/// The stride is odd, so that it visits all rings of a cloud that is stored firing by firing.
std::size_t stride_for(std::size_t points) { return (points / kMaxCandidates) | 1U; }

struct TimeSpan {
  double first = 0.0;
  double last = 0.0;
};

TimeSpan time_span(const PointCloud& cloud, const std::vector<std::uint32_t>& indices) {
  if (!cloud.has_times() || indices.empty()) return {};
  float first = cloud.times[indices.front()];
  float last = first;
  for (const std::uint32_t i : indices) {
    first = std::min(first, cloud.times[i]);
    last = std::max(last, cloud.times[i]);
  }
  return {static_cast<double>(first), static_cast<double>(last)};
}

}  // namespace

void AdaptiveCell::adapt(std::size_t points) {
  // Points lie on surfaces, so their number is inversely proportional to the square of the edge.
  const double factor = std::sqrt(static_cast<double>(points) / wanted_points_);
  edge_ = std::clamp(edge_ * factor, kMinCellFraction * largest_, largest_);
}

SweepSampler::SweepSampler(const FrontEndConfig& config)
    : sparse_cell_(config.scan_resolution, kWantedMatchedPoints),
      dense_cell_(config.insertion_resolution, kWantedInsertedPoints),
      max_range_(config.max_range),
      sparse_sampler_(kSparseTableBits),
      dense_sampler_(kDenseTableBits) {}

void SweepSampler::set_viewpoint_at_origin() {
  sparse_.viewpoint = dense_.viewpoint = between_rings_.viewpoint = Eigen::Vector3f::Zero();
}

void SweepSampler::sample_sparse_once(const Scan& scan, std::size_t phase) {
  const std::size_t stride = stride_for(scan.cloud.size());
  const auto& indices = sparse_sampler_.sample(
      scan.cloud,
      {sparse_cell_.edge(), kMinRange, max_range_, stride, phase % stride, scattered_order_});
  const TimeSpan span = time_span(scan.cloud, indices);
  reference_ = 0.5 * (span.first + span.last);
  duration_ = span.last - span.first;
  sparse_.assign(scan.cloud, indices, reference_);
  rotate_upwards(sparse_, elevation_shift_);
  sparse_cell_.adapt(indices.size());
}

void SweepSampler::sample(const Scan& scan, std::size_t phase) {
  // If the match also uses all points (stride 1), both samples have nearly the same bias, and the
  // order does not matter.
  scattered_order_ = stride_for(scan.cloud.size()) > 1 && in_sweep_order(scan.cloud);
  sample_sparse_once(scan, phase);
  if (!std::exchange(sparse_cell_adapted_, true)) sample_sparse_once(scan, phase);
  assign_points();
  leaves_out_points_ = false;
}

void SweepSampler::leave_out(const PointMarks& marks) {
  sparse_.remove(marks);
  assign_points();
  leaves_out_points_ = true;
}

void SweepSampler::assign_points() {
  points_.assign(sparse_.x, sparse_.y, sparse_.z, sparse_.s, sparse_.viewpoint);
}

void SweepSampler::sample_dense_once(const Scan& scan) {
  const auto& indices = dense_sampler_.sample(
      scan.cloud, {dense_cell_.edge(), kMinRange, max_range_, 1, 0, scattered_order_});
  dense_.assign(scan.cloud, indices, reference_);
  rotate_upwards(dense_, elevation_shift_);
  dense_cell_.adapt(indices.size());
}

const SampledPoints& SweepSampler::sample_dense(const Scan& scan) {
  sample_dense_once(scan);
  if (!std::exchange(dense_cell_adapted_, true)) sample_dense_once(scan);
  return dense_;
}

const SampledPoints& SweepSampler::sample_between_rings(const Scan& scan, RingSurfaces surfaces) {
  ring_interpolator_.interpolate(scan.cloud, {reference_, dense_cell_.edge(), max_range_, surfaces},
                                 between_rings_);
  rotate_upwards(between_rings_, elevation_shift_);
  return between_rings_;
}

double SweepSampler::median_range() const {
  if (sparse_.size() == 0) return 0.0;
  std::vector<float> squares(sparse_.size());
  for (std::size_t i = 0; i < squares.size(); ++i) {
    squares[i] =
        sparse_.x[i] * sparse_.x[i] + sparse_.y[i] * sparse_.y[i] + sparse_.z[i] * sparse_.z[i];
  }
  return std::sqrt(static_cast<double>(median(std::move(squares))));
}

}  // namespace lidar_mapping::front_end
