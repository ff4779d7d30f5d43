// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/drive_marks.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_files.hpp"
#include "lidar_mapping/moving_objects/change_list.hpp"

namespace lidar_mapping::map {

/// What the page shows beside the points.
struct WebPage {
  std::string title;
  std::optional<GeodeticDatum> datum;  ///< That of the tiles.
  double resolution = 0.0;             ///< Edge of the voxels of the map, m.
  DriveMarks marks;
  std::vector<moving_objects::Change> changes;  ///< What came and went between the visits.
  std::vector<moving_objects::Visit> visits;    ///< Those that the changes name.
};

/// The file of three.js that pages take along: the first that is there of the places where Debian's
/// packages put it. Throws InputError with the remedy if there is none.
std::filesystem::path find_three(const std::vector<std::filesystem::path>& places);
/// The places where libjs-three and node-three of Debian have it.
const std::vector<std::filesystem::path>& three_places();
/// Why no page can be made here, with the remedy; empty if one can.
std::string web_obstacle();

/// Adds a page to a folder of Entwine Point Tiles that write_ept() made: index.html, which any
/// server of files serves, and the folder viewer/ with what it needs, so that it asks no other
/// host. viewer/overview.js holds the coarsest levels for a page that is opened as a file, where
/// browsers let it read nothing else. Throws FileError, and InputError without three.js.
void add_web_page(const WebPage& page, const std::filesystem::path& tiles);

}  // namespace lidar_mapping::map
