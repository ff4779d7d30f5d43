// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/pcd_header.hpp"
#include "lidar_mapping/session/cloud_store.hpp"
#include "lidar_mapping/session/pcd_points.hpp"

namespace lidar_mapping::session {

namespace {

/// PCL prints a warning for each field of the point type that the file does not have, so the point
/// type is chosen by the file.
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

[[noreturn]] void throw_unreadable(const std::filesystem::path& path, const std::string& problem) {
  throw FileError("cannot read " + path.string() + ": " + problem +
                  "; it is no PCD file or a damaged one");
}

}  // namespace

PointCloud read_pcd(const std::filesystem::path& path) {
  const PcdHeader header = read_pcd_header(path);
  if (!header.has_float_coordinates())
    throw_unreadable(path, "it has no fields x y z of 4-byte floats");
  if (header.points == 0) return {};
  if (header.text == pcd_header(header.points)) {
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(header.text.size()));
    PointCloud cloud;
    cloud.points.resize(header.points);
    file.read(reinterpret_cast<char*>(cloud.points.data()),
              static_cast<std::streamsize>(header.points * sizeof(Point)));
    if (!file) throw_unreadable(path, "its end is missing");
    return cloud;
  }
  const pcl::PCLPointCloud2 raw = read_pcd_points(path, header);
  return has_intensity(raw) ? from_pcl<pcl::PointXYZI>(raw) : from_pcl<pcl::PointXYZ>(raw);
}

void write_pcd(const std::filesystem::path& path, const PointCloud& cloud) {
  static_assert(sizeof(Point) == 16);
  write_stream_atomically(path, [&](std::ostream& file) {
    file << pcd_header(cloud.size());
    file.write(reinterpret_cast<const char*>(cloud.points.data()),
               static_cast<std::streamsize>(cloud.size() * sizeof(Point)));
  });
}

}  // namespace lidar_mapping::session
