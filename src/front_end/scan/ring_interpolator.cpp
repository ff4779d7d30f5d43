// SPDX-License-Identifier: BSD-3-Clause
#include "scan/ring_interpolator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Number of points that are used. Chosen: some of each ring in each column, and all points of a
/// sensor with sixteen rings.
constexpr std::size_t kMaxPoints = 32000;
/// Nearer points belong to the vehicle; chosen as in sweep_sampler.cpp.
constexpr float kMinRange = 1.0F;  // m
/// Points whose slopes differ by less belong to the same ring. Chosen: half of what the narrowest
/// rings are apart (a third of a degree), as a tilted sensor sees a ring at several slopes.
constexpr float kSameRingSlope = 0.0026F;
/// Largest distance of a point from the line through its neighbours: ranges have a noise of some
/// centimetres, and the ground is rough by a tenth of a metre. Tried: with 0.05 m, the error of 15
/// simulated starts is 0.10 degrees after half a metre instead of 0.08.
constexpr float kMaxLineDistance = 0.15F;  // m
/// Rings that are farther apart need not lie on one surface. Tried: without a limit the drift in
/// simulated towns and hills is some percent larger; with 5 m the error of their starts is larger
/// by half.
constexpr float kMaxGap = 8.0F;  // m

/// Steepest slope of level ground: the tangent of 20 degrees. Chosen: above all ramps; stairs are
/// steeper.
constexpr float kMaxGroundSlope = 0.36F;

/// A pseudo-angle from 0 to 4 that increases with the azimuth and replaces it: it needs no arc
/// tangent.
float pseudo_angle(float x, float y) {
  const float t = y / (std::abs(x) + std::abs(y));
  if (x < 0.0F) return 2.0F - t;
  return y < 0.0F ? 4.0F + t : t;
}

float distance_to_line(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                       const Eigen::Vector3f& b) {
  return (p - a).cross(b - a).norm() / (b - a).norm();
}

}  // namespace

void RingInterpolator::collect(const PointCloud& cloud, const Eigen::Vector3f& origin,
                               double max_range) {
  const std::size_t stride = (cloud.size() / kMaxPoints) | 1U;
  const auto farthest = static_cast<float>(max_range * max_range);
  ring_points_.clear();
  column_numbers_.clear();
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    const Eigen::Vector3f p = cloud.points[i].position() - origin;
    const float square = p.x() * p.x() + p.y() * p.y();
    if (!(square > kMinRange * kMinRange && square < farthest) || !std::isfinite(p.z())) continue;
    const float column = 0.25F * static_cast<float>(kColumns) * pseudo_angle(p.x(), p.y());
    column_numbers_.push_back(
        static_cast<std::uint16_t>(std::min(column, static_cast<float>(kColumns - 1))));
    ring_points_.push_back(
        {p, cloud.has_times() ? cloud.times[i] : 0.0F, p.z() / std::sqrt(square)});
  }
}

void RingInterpolator::sort_by_columns() {
  column_begins_.fill(0);
  for (const std::uint16_t number : column_numbers_) ++column_begins_[number + 1U];
  for (std::size_t k = 0; k < kColumns; ++k) column_begins_[k + 1] += column_begins_[k];
  std::array<std::size_t, kColumns + 1> next = column_begins_;
  sorted_points_.resize(ring_points_.size());
  for (std::size_t i = 0; i < ring_points_.size(); ++i)
    sorted_points_[next[column_numbers_[i]]++] = ring_points_[i];
}

/// Keeps one point of each ring.
RingInterpolator::Column RingInterpolator::column(std::size_t number) {
  RingPoint* const begin = sorted_points_.data() + column_begins_[number];
  RingPoint* const end = sorted_points_.data() + column_begins_[number + 1];
  std::sort(begin, end, [](const RingPoint& a, const RingPoint& b) {
    return a.slope != b.slope ? a.slope < b.slope : a.p.x() < b.p.x();
  });
  RingPoint* kept = begin;
  float last = -std::numeric_limits<float>::infinity();
  for (const RingPoint* point = begin; point != end; ++point) {
    const float slope = point->slope;
    if (slope - last > kSameRingSlope) *kept++ = *point;
    last = slope;
  }
  return {begin, kept};
}

bool RingInterpolator::is_straight(const Column& column, const RingPoint* point) {
  return point > column.begin && point + 1 < column.end &&
         distance_to_line(point->p, (point - 1)->p, (point + 1)->p) < kMaxLineDistance;
}

bool RingInterpolator::has_surface(const Column& column, const RingPoint* point,
                                   RingSurfaces surfaces) {
  const bool begins = is_straight(column, point);
  const bool ends = is_straight(column, point + 1);
  if (surfaces == RingSurfaces::kAll) return begins || ends;
  const Eigen::Vector3f d = (point + 1)->p - point->p;
  return begins && ends && point->p.z() < 0.0F && (point + 1)->p.z() < 0.0F &&
         std::abs(d.z()) < kMaxGroundSlope * d.head<2>().norm();
}

void RingInterpolator::interpolate_column(const Column& column, std::size_t number,
                                          const RingInterpolationOptions& options,
                                          SampledPoints& points) {
  const auto spacing = static_cast<float>(options.spacing);
  for (const RingPoint* point = column.begin; point + 1 < column.end; ++point) {
    const RingPoint& a = *point;
    const RingPoint& b = *(point + 1);
    const Eigen::Vector3f segment = b.p - a.p;
    const float gap = segment.norm();
    if (gap < spacing || gap > kMaxGap) continue;
    if (!has_surface(column, point, options.surfaces)) continue;
    // Near the sensor the columns are close together, so not all of them are needed.
    const float column_width = 0.5F * (a.p + b.p).norm() * static_cast<float>(2.0 * kPi / kColumns);
    if (number % std::max<std::size_t>(1, static_cast<std::size_t>(spacing / column_width)) != 0)
      continue;
    const float segments = std::ceil(gap / spacing);
    for (float m = 1.0F; m < segments; m += 1.0F) {
      const float fraction = m / segments;
      points.push_back(a.p + fraction * segment, a.time + fraction * (b.time - a.time));
    }
  }
}

void RingInterpolator::interpolate(const PointCloud& cloud, const RingInterpolationOptions& options,
                                   SampledPoints& points) {
  for (auto* array : {&points.x, &points.y, &points.z, &points.s}) array->clear();
  if (!points.viewpoint) return;
  const Eigen::Vector3f origin = *points.viewpoint;
  collect(cloud, origin, options.max_range);
  sort_by_columns();
  for (std::size_t k = 0; k < kColumns; ++k) interpolate_column(column(k), k, options, points);
  const auto reference = static_cast<float>(cloud.has_times() ? options.reference : 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.x[i] += origin.x();
    points.y[i] += origin.y();
    points.z[i] += origin.z();
    points.s[i] -= reference;
  }
}

}  // namespace lidar_mapping::front_end
