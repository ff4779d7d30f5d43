// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/transformed_points.hpp"

#include "visibility/observing_scan.hpp"

namespace lidar_mapping::moving_objects {

/// Layer of a point by its height: on the ground; on what its own key frame observed as ground and
/// others a little below; at the base of an object; on the body of an object; or above the height
/// of cars. Or isolated in the air, where nothing can stand.
enum class Layer : char { kGround, kRaised, kBase, kBody, kAbove, kIsolated };

/// Models of the ground below the points of a key frame: as the key frame observed it, as it and
/// its neighbours observed it, and as key frames observed it that pass by further away.
struct GroundModels {
  explicit GroundModels(const TransformedPoints& points)
      : area(points), own(area), near(area), wide(area) {}
  GroundModels(const GroundModels&) = delete;
  GroundModels& operator=(const GroundModels&) = delete;

  GroundArea area;
  LocalGround own;
  LocalGround near;
  LocalGround wide;
};

/// Assigns a layer to each point. The ground that the own key frame observed has priority, because
/// an error of its pose does not shift it. If that is a roof, the ground observed by its neighbours
/// is used; if these observed only a roof, too, as happens far ahead with few beams, the wide model
/// is used. Points out of range belong to the ground.
std::vector<Layer> classify_layers(const TransformedPoints& points, GroundModels& ground_models);

/// Indices of the points that need votes; those on the ground or at the base of an object do not.
std::vector<std::uint32_t> voted_points(const std::vector<Layer>& layers);

/// Indices of points that were voted moving and have hardly any neighbours: drops, flakes, tips of
/// leaves.
std::vector<std::uint32_t> isolated_points(const TransformedPoints& points,
                                           const std::vector<Vote>& votes);

/// Indices of the points to remove, given the votes on points above the base (doc/map.md).
/// Neighbouring points are decided together: unobserved points follow those around them, and
/// objects that stand alone are removed as a whole, with their base.
std::vector<std::uint32_t> moving_points(const TransformedPoints& points,
                                         const std::vector<Vote>& votes,
                                         const std::vector<Layer>& layers);

/// Indices of the points above the ground of which the votes around say that they moved. Objects
/// are not decided as a whole: a house that was taken down may have touched one that stands.
std::vector<std::uint32_t> outvoted_points(const TransformedPoints& points,
                                           const std::vector<Vote>& votes,
                                           const std::vector<Layer>& layers);

}  // namespace lidar_mapping::moving_objects
