// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/map/map_tile.hpp"

#include "files/point_octree.hpp"

namespace lidar_mapping::map {

/// What a point knows from the key frame that observed it first.
struct PointOrigin {
  Stamp stamp = 0;
  std::uint16_t drive = 0;  ///< Number of the segment.
};

/// How Entwine Point Tiles are made.
struct EptOptions {
  std::optional<GeodeticDatum> datum;  ///< Origin of the map frame; none: no georeference.
  std::function<PointOrigin(KeyFrameIndex)> origin;
  OctreeOptions octree;
};

/// Writes Entwine Point Tiles 1.0.0 (https://entwine.io/entwine-point-tile.html) with binary data
/// into `folder`: ept.json, ept-hierarchy and ept-data. Coordinates are those of a MillimetreFrame,
/// with the system of the datum. Dimensions: X, Y, Z; Intensity, in which 65535 is the largest of
/// the map, as in LAS; PointSourceId, the drive; GpsTime, seconds of the stamp. The points wait in
/// unnamed files in `folder`, so memory does not grow with the map. Throws FileError, and
/// InputError for a map without points or one too large for 32 bits.
void write_ept(const TileSource& tiles, const EptOptions& options,
               const std::filesystem::path& folder);

/// The system of an EPSG code of UtmFrame as well-known text (OGC 01-009), which readers without a
/// table of codes need.
std::string utm_wkt(std::uint16_t epsg);

}  // namespace lidar_mapping::map
