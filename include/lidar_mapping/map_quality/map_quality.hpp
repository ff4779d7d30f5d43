// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::map_quality {

/// How a map is judged without truth (doc/map_quality.md).
struct QualityConfig {
  double range_noise = 0.02;  ///< m, standard deviation of the sensor's ranges
  /// The LiDAR in base_link, m. Without it the ratio to the noise means nothing, and surfaces are
  /// not told apart by the side from which they were seen.
  std::optional<Eigen::Vector3d> p_base_sensor = Eigen::Vector3d::Zero();
  double reach = 30.0;  ///< m, points farther from their key frame are left out
  int group = 5;        ///< consecutive key frames whose points are one group
};

/// Spread of the points of planar places about their planes.
struct Thickness {
  std::size_t cells = 0;
  double median = 0.0;         ///< m
  double high = 0.0;           ///< m, 90 % lie below
  double median_ratio = 0.0;   ///< to the spread that range noise alone gives: 1 is perfect
  double median_within = 0.0;  ///< m, of single groups: what poses have no part in
};

struct LocalThickness {
  Thickness ground;
  Thickness walls;
  double planar_share = 0.0;  ///< planar cells among those with enough extent
};

/// Thickness in cells of 0.5 m. The plane of a cell comes from one group of consecutive key frames
/// alone and all groups are measured against it, so layers that the key frames lay apart count.
LocalThickness local_thickness(const KeyFramePoses& poses, CloudSource& clouds,
                               const QualityConfig& config);

/// How a later pass of a place lies against the earlier ones, in the axes of the vehicle.
struct GhostVector {
  KeyFrameIndex key_frame = 0;  ///< in the middle of the place, of the later pass
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of that key frame, m
  double along = 0.0;                                  ///< m
  double left = 0.0;                                   ///< m
  double up = 0.0;                                     ///< m
  double yaw = 0.0;                                    ///< rad
  std::size_t planes = 0;                              ///< that have a partner in both passes
  double residual = 0.0;                               ///< m, median distance that is left over

  double size() const { return Eigen::Vector3d(along, left, up).norm(); }
};

/// A vector for each 10 m of the way on which the vehicle came back to a place, by registering the
/// planes of the later pass onto those of the earlier ones that were seen from the same side, on
/// the same storey; places with fewer than 15 common planes have none.
std::vector<GhostVector> ghost_vectors(const KeyFramePoses& poses, CloudSource& clouds,
                                       const QualityConfig& config);

/// The points of a place, for pictures: x along, y left, z up from its key frame, m.
struct PlacePoints {
  std::vector<Eigen::Vector3f> earlier;
  std::vector<Eigen::Vector3f> later;
};

/// The points from which ghost_vectors() found what it says of a place.
PlacePoints place_points(const KeyFramePoses& poses, CloudSource& clouds,
                         const QualityConfig& config, const GhostVector& place);

/// Mean map entropy (Razlaw et al. 2015), natural logarithm: only good for comparing two sets of
/// poses with the very same points, as it depends on how dense these are.
struct MapEntropy {
  double mean = 0.0;
  double radius = 0.0;      ///< m, of the neighbourhoods
  std::size_t points = 0;   ///< at which it was taken
  double neighbours = 0.0;  ///< mean number
};

/// At some points each of up to 60 places along the way.
MapEntropy mean_map_entropy(const KeyFramePoses& poses, CloudSource& clouds);

}  // namespace lidar_mapping::map_quality
