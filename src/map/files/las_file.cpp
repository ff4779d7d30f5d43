// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include <Eigen/Geometry>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"

#include "files/millimetre_frame.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

constexpr std::uint16_t kHeaderSize = 227;  // bytes, by LAS 1.2
constexpr std::uint16_t kPointSize = 20;    // bytes, of point format 0 by LAS 1.2
// Return number 1 (bits 0 to 2) of 1 (bits 3 to 5), by LAS 1.2.
constexpr std::uint8_t kOnlyReturn = 0x09;
constexpr std::uint16_t kMetre = 9001;  // the metre as a unit, by EPSG

/// Bytes in the order of the format, which is little endian like every processor that this runs on.
class Bytes {
 public:
  template <typename Number>
  Bytes& add(Number number) {
    const auto* begin = reinterpret_cast<const char*>(&number);
    data_.append(begin, sizeof number);
    return *this;
  }
  Bytes& text(const std::string& text, std::size_t size) {
    std::string padded = text;
    padded.resize(size, '\0');
    data_ += padded;
    return *this;
  }
  const std::string& data() const { return data_; }

 private:
  std::string data_;
};

/// GeoTIFF keys: a projected system by its EPSG code, metres in all directions.
std::string georeference(std::uint16_t epsg) {
  if (epsg == 0) return {};
  const std::array<std::uint16_t, 20> keys = {1,    1,    0, 4, 1024,   0,    1, 1, 3072,  0, 1,
                                              epsg, 3076, 0, 1, kMetre, 4099, 0, 1, kMetre};
  Bytes bytes;
  bytes.add(std::uint16_t{0}).text("LASF_Projection", 16).add(std::uint16_t{34735});
  bytes.add(static_cast<std::uint16_t>(sizeof keys)).text("GeoTIFF keys", 32);
  for (const std::uint16_t key : keys) bytes.add(key);
  return bytes.data();
}

std::string header(std::uint64_t point_count, const Eigen::AlignedBox3d& box,
                   const MillimetreFrame& frame) {
  const std::string reference = georeference(frame.epsg());
  const auto points = static_cast<std::uint32_t>(point_count);
  Bytes bytes;
  bytes.text("LASF", 4).add(std::uint32_t{0}).text("", 16);
  bytes.add(std::uint8_t{1}).add(std::uint8_t{2}).text("", 32).text("lidar_mapping", 32);
  bytes.add(std::uint32_t{0}).add(kHeaderSize);  // no date, so that equal maps give equal files
  bytes.add(static_cast<std::uint32_t>(kHeaderSize + reference.size()));
  bytes.add(std::uint32_t{reference.empty() ? 0U : 1U}).add(std::uint8_t{0}).add(kPointSize);
  bytes.add(points).add(points).text("", 16);
  for (int i = 0; i < 3; ++i) bytes.add(kMillimetre);
  for (int i = 0; i < 3; ++i) bytes.add(frame.offset()[i]);
  for (int i = 0; i < 3; ++i) bytes.add(box.max()[i]).add(box.min()[i]);
  return bytes.data() + reference;
}

/// The points of a tile as the file holds them; `box` grows by them.
std::string records(const MapTile& tile, const MillimetreFrame& frame, float intensity_scale,
                    Eigen::AlignedBox3d& box) {
  Bytes bytes;
  for (const Point& point : tile.cloud.points) {
    const Eigen::Vector3d p = frame.projected(tile.origin + point.position().cast<double>());
    const auto millimetres = frame.millimetres(p);
    for (const std::int32_t coordinate : millimetres) bytes.add(coordinate);
    box.extend(frame.position_of(millimetres));
    const float intensity = std::clamp(point.intensity * intensity_scale, 0.0F, 65535.0F);
    bytes.add(static_cast<std::uint16_t>(std::lround(intensity)));
    bytes.add(kOnlyReturn).add(std::uint8_t{0}).add(std::int8_t{0}).add(std::uint8_t{0});
    bytes.add(std::uint16_t{0});
  }
  return bytes.data();
}

}  // namespace

void write_las(const std::filesystem::path& path, const TileSource& tiles,
               const std::optional<GeodeticDatum>& datum, float max_intensity) {
  MillimetreFrame frame(datum);
  const float intensity_scale = 65535.0F / (max_intensity > 0.0F ? max_intensity : 1.0F);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    std::uint64_t points = 0;
    Eigen::AlignedBox3d box;
    // has the right length already; its values are known at the end
    file << header(points, box, frame);
    tiles([&](const MapTile& tile) {
      if (points == 0) frame.set_offset_near(tile.origin);
      file << records(tile, frame, intensity_scale, box);
      points += tile.cloud.size();
    });
    if (points > std::numeric_limits<std::uint32_t>::max()) {
      throw FileError("the map has more points than a LAS 1.2 file can hold; choose tiles");
    }
    file.seekp(0);
    file << header(points, box, frame);
    if (!file.flush()) throw FileError("cannot write " + path.string() + "; check the free space");
  });
}

}  // namespace lidar_mapping::map
