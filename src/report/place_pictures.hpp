// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/map_quality/map_quality.hpp"

#include "json.hpp"

namespace lidar_mapping::report {

enum class View { kFromAbove, kAcross };

/// Pictures of a place that was driven twice, for the report: {"title", "passes": [earlier,
/// later]}, points of each as [along, left] from above or [left, up] across, mm in the axes of the
/// vehicle. A narrow slice shows the distance of passes best; if a pass has hardly any points in
/// it, a wider one is used.
json::Json place_picture(const map_quality::PassPoints& points, View view);

}  // namespace lidar_mapping::report
