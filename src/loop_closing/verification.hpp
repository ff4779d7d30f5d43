// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "point_to_plane.hpp"
#include "range_image.hpp"

namespace lidar_mapping::loop_closing {

/// A key frame as it is held against a submap; everything in its base_link.
struct QueryScan {
  std::vector<Eigen::Vector3f> points;
  std::vector<bool> above_ground;  ///< of points
  RangeImage image;                ///< of this key frame alone
};

/// The surroundings of an old key frame, in its base_link.
struct Submap {
  SurfaceCloud surface;
  std::vector<bool> above_ground;  ///< of surface.tree.points()
  RangeImage image;                ///< of the middle key frame alone
  /// Of the LiDAR in base_link.
  Eigen::Vector3f p_base_lidar = Eigen::Vector3f::Zero();
};

/// What speaks for or against a pose of a key frame in a submap (doc/loop_closing.md).
struct MatchFigures {
  int tested_points = 0;  ///< above ground, within 40 m
  double overlap = 0.0;   ///< share of these with a submap point within 0.3 m
  /// Share of the points above ground that stand in what the other side saw to be free; the larger
  /// share of both ways.
  double free_space_violation = 0.0;
  /// How well the walls pin the horizontal position: 0.5 at best, 0 in a smooth tunnel.
  double horizontal_eigenvalue = 0.0;
  /// Mean squared distance of the points with a partner within the range, m^2; the squared range if
  /// none has one.
  double fitness = 0.0;
  double roofed = 0.0;  ///< roofed_fraction() of the submap, where it matters
};

/// Share of the places within 15 m that have a level surface overhead, 0 to 1.
double roofed_fraction(const Submap& submap);

MatchFigures measure_match(const QueryScan& query, const Submap& submap, const Pose& T_submap_query,
                           double fitness_score_max_range);

}  // namespace lidar_mapping::loop_closing
