// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/text.hpp"

#include "files/ept_file.hpp"

namespace lidar_mapping::map {

namespace {

constexpr int kNorth = 32600;  // by EPSG: zone 1 of the northern half is the next number
constexpr int kSouth = 32700;  // by EPSG: zone 1 of the southern half is the next number
constexpr int kPolar = 61;     // by EPSG: in the place of a zone

/// WGS 84 in degrees, by EPSG 4326.
constexpr const char* kGeographic =
    "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,"
    "AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],"
    "PRIMEM[\"Greenwich\",0,AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,"
    "AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]]";

std::string system(const std::string& name, const std::string& projection, int epsg) {
  return formatted(
      "PROJCS[\"%s\",%s,%s,UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]],"
      "AUTHORITY[\"EPSG\",\"%d\"]]",
      name.c_str(), kGeographic, projection.c_str(), epsg);
}

// The numbers are those of the definition of UTM and UPS (NGA.SIG.0012).
std::string zone_wkt(int zone, bool is_south, int epsg) {
  const std::string projection = formatted(
      "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
      "PARAMETER[\"central_meridian\",%d],PARAMETER[\"scale_factor\",0.9996],"
      "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",%d]",
      6 * zone - 183, is_south ? 10000000 : 0);
  return system(formatted("WGS 84 / UTM zone %d%c", zone, is_south ? 'S' : 'N'), projection, epsg);
}

std::string polar_wkt(bool is_south, int epsg) {
  const std::string projection = formatted(
      "PROJECTION[\"Polar_Stereographic\"],PARAMETER[\"latitude_of_origin\",%d],"
      "PARAMETER[\"central_meridian\",0],PARAMETER[\"scale_factor\",0.994],"
      "PARAMETER[\"false_easting\",2000000],PARAMETER[\"false_northing\",2000000]",
      is_south ? -90 : 90);
  return system(is_south ? "WGS 84 / UPS South (N,E)" : "WGS 84 / UPS North (N,E)", projection,
                epsg);
}

}  // namespace

std::string utm_wkt(std::uint16_t epsg) {
  const bool is_south = epsg > kSouth;
  const int zone = epsg - (is_south ? kSouth : kNorth);
  return zone == kPolar ? polar_wkt(is_south, epsg) : zone_wkt(zone, is_south, epsg);
}

}  // namespace lidar_mapping::map
