// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/common/free_space_image.hpp"

#include "decision/elevation_range.hpp"
#include "matching/point_to_plane.hpp"

namespace lidar_mapping::loop_closing {

/// The scan of a key frame that is compared with a submap; all in its base_link.
struct QueryScan {
  std::vector<Eigen::Vector3f> points;
  std::vector<bool> above_ground;  ///< per point
  FreeSpaceImage image;            ///< of this key frame alone
  double sight = 0.0;              ///< range_of_sight() of this key frame alone, m
};

/// The surroundings of an older key frame, in its base_link.
struct Submap {
  SurfaceCloud surface;
  std::vector<bool> above_ground;  ///< per point of surface.tree().points()
  FreeSpaceImage image;            ///< of the middle key frame alone
  double sight = 0.0;              ///< range_of_sight() of the middle key frame alone, m
  /// Position of the LiDAR in base_link, m.
  Eigen::Vector3f p_base_lidar = Eigen::Vector3f::Zero();
  /// What that LiDAR can see, by all scans of the segment so far; null if that is not known.
  std::shared_ptr<const ElevationRange> view;
};

/// What the LiDAR saw at one key frame alone, in its base_link.
struct SingleView {
  std::vector<Eigen::Vector3f> points;
  std::vector<bool> above_ground;  ///< per point
  FreeSpaceImage image;
};

/// Figures of a match of a key frame with a submap (doc/loop_closing.md).
struct MatchFigures {
  /// Number of points above ground within 40 m, where the LiDAR of the submap can see.
  int tested_points = 0;
  double overlap = 0.0;  ///< fraction of these with a submap point within 0.3 m
  /// Fraction of the points above ground that stand in free space of the other scan; the larger one
  /// of both directions.
  double free_space_violation = 0.0;
  /// Smaller eigenvalue of the mean n n^T of the horizontal normals: how well walls determine the
  /// horizontal position, from 0 in a smooth tunnel to 0.5.
  double horizontal_eigenvalue = 0.0;
  /// Mean squared distance of the points with a partner within the range, m^2; the squared range if
  /// there is none.
  double fitness = 0.0;
  double sight = 0.0;   ///< smaller range of sight of scan and submap, m
  double roofed = 0.0;  ///< roofed_fraction() of the submap; 0 if it was not needed
};

/// MatchFigures::free_space_violation of two key frames alone.
double free_space_violation(const SingleView& a, const SingleView& b, const Pose& T_a_b);

/// Fraction of the occupied cells within 15 m that have a level surface overhead, 0 to 1.
double roofed_fraction(const Submap& submap);

MatchFigures measure_match(const QueryScan& query, const Submap& submap, const Pose& T_submap_query,
                           double fitness_score_max_range);

}  // namespace lidar_mapping::loop_closing
