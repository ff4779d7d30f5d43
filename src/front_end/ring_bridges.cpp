// SPDX-License-Identifier: BSD-3-Clause
#include "ring_bridges.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {
namespace {

/// So many points are looked at, some of each ring in each column; all of sixteen rings.
constexpr std::size_t kLookedAt = 32000;
/// What is nearer is the vehicle.
constexpr float kMinRange = 1.0F;  // m
/// Points whose slopes differ by less are of the same ring: the narrowest rings are a third of a
/// degree apart, and a sensor that is mounted askew sees a ring at several slopes.
constexpr float kSameRing = 0.0026F;
/// Of three points on neighbouring rings the middle one may be so far from the line through the
/// others: ranges are noisy by some centimetres, and ground is rough by a tenth of a metre. With
/// 0.05 m, 15 simulated starts are off by 0.10 degrees after half a metre instead of 0.08.
constexpr float kStraight = 0.15F;  // m
/// Rings that are farther apart need not be of one surface: without a limit simulated towns and
/// hills drift by some percent more, with 5 m their starts are off by half as much again.
constexpr float kMostGap = 8.0F;  // m

/// From 0 to 4, rising with the azimuth, for which it stands: it takes no arc tangent.
float turn_of(float x, float y) {
  const float t = y / (std::abs(x) + std::abs(y));
  if (x < 0.0F) return 2.0F - t;
  return y < 0.0F ? 4.0F + t : t;
}

float distance_to_line(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                       const Eigen::Vector3f& b) {
  return (p - a).cross(b - a).norm() / (b - a).norm();
}

void push(const Eigen::Vector3f& p, float time, SampledPoints& points) {
  points.x.push_back(p.x());
  points.y.push_back(p.y());
  points.z.push_back(p.z());
  points.s.push_back(time);
}

}  // namespace

void RingBridges::collect(const PointCloud& cloud, const Eigen::Vector3f& origin,
                          double max_range) {
  const std::size_t stride = (cloud.size() / kLookedAt) | 1U;
  const auto farthest = static_cast<float>(max_range * max_range);
  seen_.clear();
  numbers_.clear();
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    const Eigen::Vector3f p = cloud.points[i].position() - origin;
    const float square = p.x() * p.x() + p.y() * p.y();
    if (!(square > kMinRange * kMinRange && square < farthest) || !std::isfinite(p.z())) continue;
    const float turn = 0.25F * static_cast<float>(kColumns) * turn_of(p.x(), p.y());
    numbers_.push_back(
        static_cast<std::uint16_t>(std::min(turn, static_cast<float>(kColumns - 1))));
    seen_.push_back({p, cloud.has_times() ? cloud.times[i] : 0.0F, p.z() / std::sqrt(square)});
  }
}

void RingBridges::sort_by_columns() {
  begins_.fill(0);
  for (const std::uint16_t number : numbers_) ++begins_[number + 1U];
  for (std::size_t k = 0; k < kColumns; ++k) begins_[k + 1] += begins_[k];
  std::array<std::size_t, kColumns + 1> next = begins_;
  sorted_.resize(seen_.size());
  for (std::size_t i = 0; i < seen_.size(); ++i) sorted_[next[numbers_[i]]++] = seen_[i];
}

/// One point of each ring.
RingBridges::Column RingBridges::column(std::size_t number) {
  Seen* const begin = sorted_.data() + begins_[number];
  Seen* const end = sorted_.data() + begins_[number + 1];
  std::sort(begin, end, [](const Seen& a, const Seen& b) {
    return a.slope != b.slope ? a.slope < b.slope : a.p.x() < b.p.x();
  });
  Seen* kept = begin;
  float last = -std::numeric_limits<float>::infinity();
  for (const Seen* s = begin; s != end; ++s) {
    const float slope = s->slope;
    if (slope - last > kSameRing) *kept++ = *s;
    last = slope;
  }
  return {begin, kept};
}

bool RingBridges::is_straight(const Column& column, const Seen* s) {
  return s > column.begin && s + 1 < column.end &&
         distance_to_line(s->p, (s - 1)->p, (s + 1)->p) < kStraight;
}

void RingBridges::bridge(const Column& column, std::size_t number, float spacing,
                         SampledPoints& points) {
  for (const Seen* s = column.begin; s + 1 < column.end; ++s) {
    const Seen& a = *s;
    const Seen& b = *(s + 1);
    const Eigen::Vector3f way = b.p - a.p;
    const float gap = way.norm();
    if (gap < spacing || gap > kMostGap) continue;
    if (!is_straight(column, s) && !is_straight(column, s + 1)) continue;
    // Near the sensor columns are close together.
    const float width = 0.5F * (a.p + b.p).norm() * static_cast<float>(2.0 * kPi / kColumns);
    if (number % std::max<std::size_t>(1, static_cast<std::size_t>(spacing / width)) != 0) continue;
    const float pieces = std::ceil(gap / spacing);
    for (float m = 1.0F; m < pieces; m += 1.0F) {
      const float share = m / pieces;
      push(a.p + share * way, a.time + share * (b.time - a.time), points);
    }
  }
}

void RingBridges::find(const PointCloud& cloud, const BridgeOptions& options,
                       SampledPoints& points) {
  for (auto* array : {&points.x, &points.y, &points.z, &points.s}) array->clear();
  if (!points.viewpoint) return;
  const Eigen::Vector3f origin = *points.viewpoint;
  collect(cloud, origin, options.max_range);
  sort_by_columns();
  for (std::size_t k = 0; k < kColumns; ++k) {
    bridge(column(k), k, static_cast<float>(options.spacing), points);
  }
  const auto reference = static_cast<float>(cloud.has_times() ? options.reference : 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.x[i] += origin.x();
    points.y[i] += origin.y();
    points.z[i] += origin.z();
    points.s[i] -= reference;
  }
}

}  // namespace lidar_mapping::front_end
