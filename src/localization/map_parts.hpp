// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "map_surfaces.hpp"
#include "place_search.hpp"

namespace lidar_mapping::localization {

/// What a MapIndex holds. Of its surfaces and appearances, most may lie in files.
class MapParts {
 public:
  MapSurfaces surfaces;
  PlaceSearch places;
};

}  // namespace lidar_mapping::localization
