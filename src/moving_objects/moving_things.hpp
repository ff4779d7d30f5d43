// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/placed_points.hpp"

#include "observing_scan.hpp"

namespace lidar_mapping::moving_objects {

/// Where a point is: on the ground, on what its own key frame saw as ground and others a little
/// below, at the foot of something, on it, or above the height of cars; or alone in the air, where
/// nothing stays.
enum class Layer : char { kGround, kRaised, kFoot, kBody, kHigh, kAlone };

/// The ground below the points of a key frame, as it saw it itself, as it and its neighbours saw
/// it, and as those saw it that come by further away.
struct Grounds {
  explicit Grounds(const PlacedPoints& points) : area(points), own(area), near(area), wide(area) {}
  Grounds(const Grounds&) = delete;
  Grounds& operator=(const Grounds&) = delete;

  GroundArea area;
  LocalGround own;
  LocalGround near;
  LocalGround wide;
};

/// Ground is what the points' own key frame saw of it, as an error of its pose does not lift that;
/// where that is a roof, the ground that its neighbours saw counts, and where they saw nothing but
/// a roof either, as far ahead with few beams, the wide one. What is out of reach is ground, too.
std::vector<Layer> layers_of(const PlacedPoints& points, Grounds& grounds);

/// Numbers of those that are said to move and have next to nobody around: drops, flakes, tips of
/// leaves.
std::vector<std::uint32_t> lonely_points(const PlacedPoints& points,
                                         const std::vector<Vote>& votes);

/// Numbers of the points that go, after the votes on those above the foot (doc/map.md). Neighbours
/// decide: what nobody saw follows those around; things that stand alone go as a whole, with their
/// foot.
std::vector<std::uint32_t> moving_points(const PlacedPoints& points, const std::vector<Vote>& votes,
                                         const std::vector<Layer>& layers);

}  // namespace lidar_mapping::moving_objects
