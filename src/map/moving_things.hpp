#pragma once

#include <vector>

#include "placed_points.hpp"
#include "witness.hpp"

namespace lidar_mapping::map {

/// Where a point is: on the ground, at the foot of something, on it, or above the height of
/// vehicles.
enum class Layer : char { kGround, kFoot, kBody, kHigh };

/// Ground is what the points' own key frame saw of it, as an error of its pose does not lift that;
/// where that is a roof, the ground that all saw counts. What is out of reach is ground, too.
std::vector<Layer> layers_of(const PlacedPoints& points, LocalGround& own, LocalGround& all);

/// Which points go, after the votes on those above the foot (doc/map.md). Neighbours decide: what
/// nobody saw follows those around; things that stand alone go as a whole, with their foot.
std::vector<bool> moving_points(const PlacedPoints& points, const std::vector<Vote>& votes,
                                const std::vector<Layer>& layers);

}  // namespace lidar_mapping::map
