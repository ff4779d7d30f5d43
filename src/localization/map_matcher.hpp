// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/localization/localizer.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "map_surfaces.hpp"
#include "scan_points.hpp"

namespace lidar_mapping::localization {

/// A pose in the map with its covariance, in the axes of base_link.
struct PoseEstimate {
  Pose T_map_base;
  Covariance6 covariance = Covariance6::Identity();
};

/// How well a scan fits to the map at a pose.
struct Agreement {
  /// Fraction of the points within 40 m that lie in voxels which the map knows, 0 to 1.
  double coverage = 0.0;
  /// Mean robust weight of the points above ground, 0 to 1; those in other voxels have none.
  double agreement = 0.0;
  std::size_t points = 0;  ///< within 40 m
};

/// A scan matched with the map.
struct MapMatch {
  PoseEstimate estimate;
  bool converged = false;
  Agreement agreement;
};

/// Matches scans with the map from a predicted pose.
class MapMatcher {
 public:
  /// The best pose near the prediction, which counts with its covariance. Where the prediction is
  /// uncertain by more than the fine voxels attract, the coarse ones are matched first. Throws
  /// FileError.
  MapMatch match(const ScanPoints& points, MapSurfaces& map, const PoseEstimate& predicted);
  /// The points that match() aligns, with their weights at a pose. Throws FileError.
  std::vector<MatchedPoint> weighted(const ScanPoints& points, MapSurfaces& map,
                                     const Pose& T_map_base);

 private:
  /// Where a search for the pose ended, and how far from the prediction it was on the way, m.
  struct Alignment {
    registration::NdtMatch match;
    double excursion = 0.0;
  };
  Alignment aligned(const ScanPoints& points, MapSurfaces& map, const PoseEstimate& predicted);
  Agreement agreement_at(const Pose& T_map_base, const ScanPoints& points, MapSurfaces& map);

  registration::NdtMatcher matcher_;
};

}  // namespace lidar_mapping::localization
