// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::map_quality {

/// Parameters of the measures of map quality that need no ground truth (doc/map_quality.md).
struct QualityConfig {
  double range_noise = 0.02;  ///< Standard deviation of the ranges of the sensor, m.
  /// Position of the LiDAR in base_link, m. Without it the ratio to the noise has no meaning, and
  /// the two sides of a surface are not distinguished.
  std::optional<Eigen::Vector3d> p_base_sensor = Eigen::Vector3d::Zero();
  double max_range = 30.0;  ///< Points farther from their key frame are left out, m.
  int group_size = 5;       ///< Number of consecutive key frames that form one group.
};

/// Spread of the points of planar cells about their planes, as statistics over the cells.
struct Thickness {
  std::size_t cells = 0;       ///< Number of planar cells.
  double median = 0.0;         ///< Median of the thickness, m.
  double percentile_90 = 0.0;  ///< 90 % quantile of the thickness, m.
  /// Median ratio to the spread that range noise alone causes; 1 is perfect.
  double median_ratio = 0.0;
  /// Median within single groups, to which errors of the poses contribute nothing, m.
  double median_within = 0.0;
};

/// Thickness of the surfaces of a map, by their orientation.
struct LocalThickness {
  Thickness ground;              ///< Cells whose normal is nearly vertical.
  Thickness walls;               ///< Cells whose normal is nearly horizontal.
  double planar_fraction = 0.0;  ///< Fraction of planar cells among those with enough extent.
};

/// Measures the thickness in cells of 0.5 m. The plane of a cell is fitted to the points of one
/// group of consecutive key frames, and the points of all groups are measured against it, so that
/// surfaces which appear doubled because of pose errors count as thick.
LocalThickness local_thickness(const KeyFramePoses& poses, CloudSource& clouds,
                               const QualityConfig& config);

/// Offset of a later pass through a location against the earlier passes, in the axes of the
/// vehicle.
struct PassMisalignment {
  KeyFrameIndex key_frame = 0;  ///< The key frame of the later pass in the middle of the location.
  /// Position of that key frame in the map frame, m.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double forward = 0.0;    ///< Offset forward, m.
  double left = 0.0;       ///< Offset to the left, m.
  double up = 0.0;         ///< Offset upwards, m.
  double yaw = 0.0;        ///< Rotation about the vertical axis, rad.
  std::size_t planes = 0;  ///< Number of planes that were matched between the passes.
  double residual = 0.0;   ///< Median distance of the planes after the registration, m.

  /// Length of the translation, m.
  double distance() const { return Eigen::Vector3d(forward, left, up).norm(); }
};

/// Measures the offset for each 10 m of the path on which the vehicle came back to a location, by
/// registering the planes of the later pass onto those of the earlier ones that were observed from
/// the same side and on the same storey. Locations with fewer than 15 common planes are left out.
std::vector<PassMisalignment> pass_misalignments(const KeyFramePoses& poses, CloudSource& clouds,
                                                 const QualityConfig& config);

/// Points of both passes at a location, for pictures: x forward, y left, z up from its key frame,
/// m.
struct PassPoints {
  std::vector<Eigen::Vector3f> earlier;  ///< Points of the earlier passes.
  std::vector<Eigen::Vector3f> later;    ///< Points of the later pass.
};

/// The points from which pass_misalignments() has computed this result.
PassPoints pass_points(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config,
                       const PassMisalignment& misalignment);

/// Mean map entropy (Razlaw et al. 2015), natural logarithm. It depends on the density of the
/// points and therefore only compares two sets of poses of the very same points.
struct MapEntropy {
  double mean = 0.0;        ///< Mean entropy of the neighbourhoods.
  double radius = 0.0;      ///< Radius of the neighbourhoods, m.
  std::size_t points = 0;   ///< Number of points at which the entropy was computed.
  double neighbours = 0.0;  ///< Mean number of points of a neighbourhood.
};

/// Computes it at a subset of the points around up to 60 locations along the path.
MapEntropy mean_map_entropy(const KeyFramePoses& poses, CloudSource& clouds);

}  // namespace lidar_mapping::map_quality
