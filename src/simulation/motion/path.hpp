// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace lidar_mapping::simulation {

/// A curve in the plane, sampled at equal distances, with continuous curvature.
class Path {
 public:
  /// Path through the corners of a polyline, each rounded with at most `radius` (m). The positions
  /// are then averaged three times over `blend` metres before and behind, which makes the curvature
  /// continuous. Stations are metres from the beginning, before blending.
  static Path rounded(const std::vector<Eigen::Vector2d>& corners, double radius,
                      double blend = 1.5);
  /// Path through points that are kSpacing apart.
  explicit Path(std::vector<Eigen::Vector2d> points);

  double length() const;
  Eigen::Vector2d position(double station) const;
  double heading(double station) const;    ///< Heading, rad, unwrapped from the beginning.
  double curvature(double station) const;  ///< Curvature, 1/m, positive to the left.
  /// The same path with slow lateral deviations of up to `amplitude` metres.
  Path weaving(double amplitude, double phase) const;

  static constexpr double kSpacing = 0.1;  ///< m; chosen: far below any radius of a bend

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> headings_;
};

}  // namespace lidar_mapping::simulation
