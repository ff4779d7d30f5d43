#include <fstream>
#include <optional>
#include <sstream>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/pcd_header.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

namespace lidar_mapping::session {

namespace {

/// PCL warns on the console about fields that a type has and the file lacks, so the type follows
/// the file.
template <typename PclPoint>
PointCloud from_pcl(const pcl::PCLPointCloud2& raw) {
  pcl::PointCloud<PclPoint> cloud;
  pcl::fromPCLPointCloud2(raw, cloud);
  PointCloud result;
  result.points.reserve(cloud.size());
  for (const PclPoint& point : cloud) {
    float intensity = 0.0F;
    if constexpr (std::is_same_v<PclPoint, pcl::PointXYZI>) intensity = point.intensity;
    result.points.push_back({point.x, point.y, point.z, intensity});
  }
  return result;
}

bool has_intensity(const pcl::PCLPointCloud2& cloud) {
  for (const auto& field : cloud.fields) {
    if (field.name == "intensity" && field.datatype == pcl::PCLPointField::FLOAT32) return true;
  }
  return false;
}

struct Header {
  std::string text;
  std::size_t points = 0;
};

/// Nothing if the header does not end, as in a file that was cut, on which PCL's reader crashes.
std::optional<Header> read_header(std::istream& file) {
  Header header;
  std::optional<std::size_t> points;
  for (std::string line; std::getline(file, line);) {
    header.text += line + "\n";
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (std::size_t count = 0; key == "POINTS" && words >> count) points = count;
    if (key != "DATA") continue;
    if (!points) return std::nullopt;
    header.points = *points;
    return header;
  }
  return std::nullopt;
}

[[noreturn]] void refuse(const std::filesystem::path& path) {
  throw FileError("cannot read " + path.string() + ": missing or damaged PCD file");
}

}  // namespace

PointCloud read_pcd(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::optional<Header> header = read_header(file);
  if (!header) refuse(path);
  if (header->points == 0) return {};  // PCL does not read it
  if (header->text == pcd_header(header->points)) {
    const auto bytes = header->points * sizeof(Point);
    if (std::filesystem::file_size(path) < header->text.size() + bytes) refuse(path);
    PointCloud cloud;
    cloud.points.resize(header->points);
    file.read(reinterpret_cast<char*>(cloud.points.data()), static_cast<std::streamsize>(bytes));
    if (!file) refuse(path);
    return cloud;
  }
  pcl::PCLPointCloud2 raw;
  if (pcl::PCDReader().read(path.string(), raw) < 0) refuse(path);
  return has_intensity(raw) ? from_pcl<pcl::PointXYZI>(raw) : from_pcl<pcl::PointXYZ>(raw);
}

void write_pcd(const std::filesystem::path& path, const PointCloud& cloud) {
  static_assert(sizeof(Point) == 16);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file << pcd_header(cloud.size());
    file.write(reinterpret_cast<const char*>(cloud.points.data()),
               static_cast<std::streamsize>(cloud.size() * sizeof(Point)));
    file.close();
    if (!file) {
      throw FileError("cannot write " + path.string() +
                      "; check the free space and the permissions");
    }
  });
}

}  // namespace lidar_mapping::session
