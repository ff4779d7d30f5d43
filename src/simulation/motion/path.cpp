// SPDX-License-Identifier: BSD-3-Clause
#include "motion/path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Replaces corners by points on arcs.
std::vector<Eigen::Vector2d> with_arcs(const std::vector<Eigen::Vector2d>& corners, double radius) {
  std::vector<Eigen::Vector2d> chain = {corners.front()};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d back = corners[i - 1] - corners[i], ahead = corners[i + 1] - corners[i];
    const Eigen::Vector2d u = -back.normalized(), v = ahead.normalized();
    const double turn = std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v));
    const double half_tangent = std::tan(0.5 * std::abs(turn));
    const double tangent =
        std::min(radius * half_tangent, 0.48 * std::min(back.norm(), ahead.norm()));
    if (half_tangent < 1e-6) continue;
    const double r = tangent / half_tangent, side = turn > 0.0 ? 1.0 : -1.0;
    const Eigen::Vector2d start = corners[i] - tangent * u;
    const Eigen::Vector2d centre = start + side * r * Eigen::Vector2d(-u.y(), u.x());
    const int steps = std::max(2, static_cast<int>(r * std::abs(turn) / Path::kSpacing));
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Rotation2Dd rotation(turn * k / steps);
      chain.push_back(centre + rotation * Eigen::Vector2d(start - centre));
    }
  }
  chain.push_back(corners.back());
  return chain;
}

/// Points `spacing` apart along a polyline.
std::vector<Eigen::Vector2d> resampled(const std::vector<Eigen::Vector2d>& chain, double spacing) {
  std::vector<Eigen::Vector2d> points = {chain.front()};
  double due = spacing;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const Eigen::Vector2d step = chain[i] - chain[i - 1];
    const double length = step.norm();
    for (; due <= length; due += spacing) points.push_back(chain[i - 1] + due / length * step);
    due -= length;
  }
  return points;
}

/// Cubic interpolation of evenly spaced values (Catmull and Rom 1974), clamped at the ends.
template <typename T>
T interpolated(const std::vector<T>& values, double position) {
  const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
  const double clamped = std::clamp(position, 0.0, static_cast<double>(last));
  const auto i = std::min(static_cast<std::ptrdiff_t>(clamped), last - 1);
  const double u = clamped - static_cast<double>(i);
  const auto at = [&](std::ptrdiff_t k) -> T {
    if (k < 0) return 2.0 * values[0] - values[-k];
    if (k > last) return 2.0 * values[last] - values[2 * last - k];
    return values[k];
  };
  const T a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
  return 0.5 * (2.0 * b + u * (c - a) + u * u * (2.0 * a - 5.0 * b + 4.0 * c - d) +
                u * u * u * (3.0 * b - a - 3.0 * c + d));
}

std::vector<double> unwrapped_headings(const std::vector<Eigen::Vector2d>& points) {
  std::vector<double> headings(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d step =
        points[std::min(i + 1, points.size() - 1)] - points[i == 0 ? 0 : i - 1];
    headings[i] = std::atan2(step.y(), step.x());
    if (i > 0) {
      headings[i] = headings[i - 1] + std::remainder(headings[i] - headings[i - 1], 2.0 * kPi);
    }
  }
  return headings;
}

}  // namespace

Path::Path(std::vector<Eigen::Vector2d> points)
    : points_(std::move(points)), headings_(unwrapped_headings(points_)) {}

Path Path::rounded(const std::vector<Eigen::Vector2d>& corners, double radius, double blend) {
  std::vector<Eigen::Vector2d> points = resampled(with_arcs(corners, radius), kSpacing);
  return Path(smoothed(std::move(points), static_cast<int>(std::lround(blend / kSpacing)), 3));
}

double Path::length() const { return static_cast<double>(points_.size() - 1) * kSpacing; }

Eigen::Vector2d Path::position(double station) const {
  return interpolated(points_, station / kSpacing);
}

double Path::heading(double station) const { return interpolated(headings_, station / kSpacing); }

double Path::curvature(double station) const {
  return (heading(station + kSpacing) - heading(station - kSpacing)) / (2.0 * kSpacing);
}

Path Path::weaving(double amplitude, double phase) const {
  std::vector<Eigen::Vector2d> points(points_.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double station = static_cast<double>(i) * kSpacing;
    const double offset = amplitude * (0.6 * std::sin(station / 17.0 + phase) +
                                       0.4 * std::sin(station / 41.0 + 2.0 * phase));
    points[i] =
        points_[i] + offset * Eigen::Vector2d(-std::sin(headings_[i]), std::cos(headings_[i]));
  }
  return Path(std::move(points));
}

}  // namespace lidar_mapping::simulation
