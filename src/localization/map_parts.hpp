// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "map_surfaces.hpp"
#include "place_search.hpp"

namespace lidar_mapping::localization {

/// What a MapIndex holds.
class MapParts {
 public:
  MapSurfaces surfaces;
  PlaceSearch places;
};

}  // namespace lidar_mapping::localization
