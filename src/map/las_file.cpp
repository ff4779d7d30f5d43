// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/utm.hpp"

#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

constexpr double kScale = 0.001;            // m; chosen: whole millimetres hold 2000 km in 32 bits
constexpr std::uint16_t kHeaderSize = 227;  // bytes, by LAS 1.2
constexpr std::uint16_t kPointSize = 20;    // bytes, of point format 0 by LAS 1.2
constexpr std::uint8_t kOnlyReturn =
    0x09;  // return number 1 (bits 0 to 2) of 1 (bits 3 to 5), by LAS 1.2
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

/// Conversion from the map frame to the coordinates of the file: UTM in the zone of the datum, or
/// the map frame.
class Projection {
 public:
  explicit Projection(const std::optional<GeodeticDatum>& datum) {
    if (!datum) return;
    utm_.emplace(*datum);
    const Eigen::Vector3d& origin = utm_->origin();
    offset_ = {1000.0 * std::floor(origin.x() / 1000.0), 1000.0 * std::floor(origin.y() / 1000.0),
               std::floor(origin.z())};
  }

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_map) const {
    return utm_ ? utm_->from_enu(p_map) : p_map;
  }
  /// Coordinates in whole millimetres reach 2147 km from the offset: without a datum it follows
  /// from the first point of the map.
  void set_offset_near(const Eigen::Vector3d& p_map) {
    if (!utm_) offset_ = 1000.0 * (p_map / 1000.0).array().floor();
  }
  const Eigen::Vector3d& offset() const { return offset_; }
  /// Code of WGS 84 / UTM; 0 without a datum.
  std::uint16_t epsg() const { return utm_ ? utm_->epsg() : 0; }

 private:
  std::optional<UtmFrame> utm_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

struct Extent {
  std::uint64_t points = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
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

std::string header(const Extent& extent, const Projection& projection) {
  const std::string reference = georeference(projection.epsg());
  const auto points = static_cast<std::uint32_t>(extent.points);
  Bytes bytes;
  bytes.text("LASF", 4).add(std::uint32_t{0}).text("", 16);
  bytes.add(std::uint8_t{1}).add(std::uint8_t{2}).text("", 32).text("lidar_mapping", 32);
  bytes.add(std::uint32_t{0}).add(kHeaderSize);  // no date, so that equal maps give equal files
  bytes.add(static_cast<std::uint32_t>(kHeaderSize + reference.size()));
  bytes.add(std::uint32_t{reference.empty() ? 0U : 1U}).add(std::uint8_t{0}).add(kPointSize);
  bytes.add(points).add(points).text("", 16);
  for (int i = 0; i < 3; ++i) bytes.add(kScale);
  for (int i = 0; i < 3; ++i) bytes.add(projection.offset()[i]);
  for (int i = 0; i < 3; ++i) bytes.add(extent.high[i]).add(extent.low[i]);
  return bytes.data() + reference;
}

class Writer {
 public:
  Writer(std::ofstream& file, Projection& projection, float max_intensity)
      : file_(file), projection_(projection), intensity_scale_(65535.0F / max_intensity) {}

  void add(const MapTile& tile) {
    if (extent_.points == 0) projection_.set_offset_near(tile.origin);
    Bytes bytes;
    for (const Point& point : tile.cloud.points) {
      const Eigen::Vector3d p = projection_(tile.origin + point.position().cast<double>());
      extent_.low = extent_.low.cwiseMin(p);
      extent_.high = extent_.high.cwiseMax(p);
      for (int i = 0; i < 3; ++i) {
        bytes.add(
            static_cast<std::int32_t>(std::lround((p[i] - projection_.offset()[i]) / kScale)));
      }
      const float intensity = std::clamp(point.intensity * intensity_scale_, 0.0F, 65535.0F);
      bytes.add(static_cast<std::uint16_t>(std::lround(intensity)));
      bytes.add(kOnlyReturn).add(std::uint8_t{0}).add(std::int8_t{0}).add(std::uint8_t{0});
      bytes.add(std::uint16_t{0});
    }
    extent_.points += tile.cloud.size();
    file_ << bytes.data();
  }
  const Extent& extent() const { return extent_; }

 private:
  std::ofstream& file_;
  Projection& projection_;
  float intensity_scale_;
  Extent extent_;
};

}  // namespace

void write_las(const std::filesystem::path& path, const TileSource& tiles,
               const std::optional<GeodeticDatum>& datum, float max_intensity) {
  Projection projection(datum);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    // has the right length already; its values are known at the end
    file << header({}, projection);
    Writer writer(file, projection, max_intensity > 0.0F ? max_intensity : 1.0F);
    tiles([&](const MapTile& tile) { writer.add(tile); });
    if (writer.extent().points > std::numeric_limits<std::uint32_t>::max()) {
      throw FileError("the map has more points than a LAS 1.2 file can hold; choose tiles");
    }
    file.seekp(0);
    file << header(writer.extent(), projection);
    if (!file.flush()) throw FileError("cannot write " + path.string() + "; check the free space");
  });
}

}  // namespace lidar_mapping::map
