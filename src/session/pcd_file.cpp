#include <fstream>
#include <optional>
#include <sstream>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

namespace lidar_mapping::session {

namespace {

pcl::PointCloud<pcl::PointXYZI> to_pcl(const PointCloud& cloud) {
  pcl::PointCloud<pcl::PointXYZI> result;
  result.reserve(cloud.size());
  for (const Point& point : cloud.points) {
    pcl::PointXYZI converted;
    converted.getVector3fMap() = point.position();
    converted.intensity = point.intensity;
    result.push_back(converted);
  }
  return result;
}

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

/// The number of points that the header gives; nothing if the header does not end, as in a file
/// that was cut, on which PCL's reader crashes.
std::optional<std::size_t> points_in_header(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::optional<std::size_t> points;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (std::size_t count = 0; key == "POINTS" && words >> count) points = count;
    if (key == "DATA") return points;
  }
  return std::nullopt;
}

// PCL neither writes nor reads clouds without points.
constexpr const char* kEmptyFile =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
    "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 0\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 0\nDATA binary\n";

}  // namespace

PointCloud read_pcd(const std::filesystem::path& path) {
  const std::optional<std::size_t> points = points_in_header(path);
  if (points && *points == 0) return {};
  pcl::PCLPointCloud2 raw;
  if (!points || pcl::PCDReader().read(path.string(), raw) < 0) {
    throw FileError("cannot read " + path.string() + ": missing or damaged PCD file");
  }
  return has_intensity(raw) ? from_pcl<pcl::PointXYZI>(raw) : from_pcl<pcl::PointXYZ>(raw);
}

void write_pcd(const std::filesystem::path& path, const PointCloud& cloud) {
  if (cloud.empty()) return write_text_atomically(path, kEmptyFile);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    const FileError problem("cannot write " + path.string() +
                            "; check the free space and the permissions");
    try {
      if (pcl::PCDWriter().writeBinary(temporary.string(), to_pcl(cloud)) < 0) throw problem;
    } catch (const pcl::IOException&) {
      throw problem;
    }
  });
}

}  // namespace lidar_mapping::session
