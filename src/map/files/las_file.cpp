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

/// What the header of a file says of its points.
struct LasExtent {
  std::uint64_t points = 0;
  Eigen::AlignedBox3d box;
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

std::string header(const LasExtent& extent, const MillimetreFrame& frame) {
  const std::string reference = georeference(frame.epsg());
  const auto points = static_cast<std::uint32_t>(extent.points);
  Bytes bytes;
  bytes.text("LASF", 4).add(std::uint32_t{0}).text("", 16);
  bytes.add(std::uint8_t{1}).add(std::uint8_t{2}).text("", 32).text("lidar_mapping", 32);
  bytes.add(std::uint32_t{0}).add(kHeaderSize);  // no date, so that equal maps give equal files
  bytes.add(static_cast<std::uint32_t>(kHeaderSize + reference.size()));
  bytes.add(std::uint32_t{reference.empty() ? 0U : 1U}).add(std::uint8_t{0}).add(kPointSize);
  bytes.add(points).add(points).text("", 16);
  for (int i = 0; i < 3; ++i) bytes.add(kMillimetre);
  for (int i = 0; i < 3; ++i) bytes.add(frame.offset()[i]);
  for (int i = 0; i < 3; ++i) bytes.add(extent.box.max()[i]).add(extent.box.min()[i]);
  return bytes.data() + reference;
}

class Writer {
 public:
  Writer(std::ofstream& file, MillimetreFrame& frame, float max_intensity)
      : file_(file), frame_(frame), intensity_scale_(65535.0F / max_intensity) {}

  void add(const MapTile& tile) {
    if (extent_.points == 0) frame_.set_offset_near(tile.origin);
    Bytes bytes;
    for (const Point& point : tile.cloud.points) {
      const Eigen::Vector3d p = frame_.projected(tile.origin + point.position().cast<double>());
      extent_.box.extend(p);
      for (const std::int32_t coordinate : frame_.millimetres(p)) bytes.add(coordinate);
      const float intensity = std::clamp(point.intensity * intensity_scale_, 0.0F, 65535.0F);
      bytes.add(static_cast<std::uint16_t>(std::lround(intensity)));
      bytes.add(kOnlyReturn).add(std::uint8_t{0}).add(std::int8_t{0}).add(std::uint8_t{0});
      bytes.add(std::uint16_t{0});
    }
    extent_.points += tile.cloud.size();
    file_ << bytes.data();
  }
  const LasExtent& extent() const { return extent_; }

 private:
  std::ofstream& file_;
  MillimetreFrame& frame_;
  float intensity_scale_;
  LasExtent extent_;
};

}  // namespace

void write_las(const std::filesystem::path& path, const TileSource& tiles,
               const std::optional<GeodeticDatum>& datum, float max_intensity) {
  MillimetreFrame frame(datum);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    // has the right length already; its values are known at the end
    file << header({}, frame);
    Writer writer(file, frame, max_intensity > 0.0F ? max_intensity : 1.0F);
    tiles([&](const MapTile& tile) { writer.add(tile); });
    if (writer.extent().points > std::numeric_limits<std::uint32_t>::max()) {
      throw FileError("the map has more points than a LAS 1.2 file can hold; choose tiles");
    }
    file.seekp(0);
    file << header(writer.extent(), frame);
    if (!file.flush()) throw FileError("cannot write " + path.string() + "; check the free space");
  });
}

}  // namespace lidar_mapping::map
