// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/map_quality/map_quality.hpp"

#include "json.hpp"

namespace lidar_mapping::report {

enum class View { kFromAbove, kAcross };

/// What the report shows of a place that was driven twice: {"title", "passes": [earlier, later]},
/// points of each as [along, left] from above or [left, up] across, mm in the axes of the vehicle.
/// A narrow slice shows best how far passes lie apart; where one of them has next to nothing in it,
/// a wider one is taken.
json::Json place_picture(const map_quality::PassPoints& points, View view);

}  // namespace lidar_mapping::report
