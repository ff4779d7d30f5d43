#include "lidar_mapping/map/map_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

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

std::string line(const char* format, double a, double b, double c) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b, c);
  return text;
}

std::string to_yaml(const PointCloud& map, const MapDescription& description) {
  Eigen::Vector3f low = map.points.front().position();
  Eigen::Vector3f high = low;
  for (const Point& point : map.points) {
    low = low.cwiseMin(point.position());
    high = high.cwiseMax(point.position());
  }
  const auto bound = [](const char* format, const Eigen::Vector3f& p) {
    return line(format, static_cast<double>(p.x()), static_cast<double>(p.y()),
                static_cast<double>(p.z()));
  };
  std::string text = "# Map in metres, x east, y north, z up where there is a datum.\n";
  text += "frame: " + description.frame + "\n";
  if (description.datum) {
    text += line("datum: {latitude: %.10f, longitude: %.10f, altitude: %.4f}\n",
                 description.datum->latitude_deg, description.datum->longitude_deg,
                 description.datum->altitude_m);
  } else {
    text += "datum: null\n";
  }
  text += line("resolution: %.6g\n", description.resolution, 0.0, 0.0);
  text += "points: " + std::to_string(map.size()) + "\n";
  text += bound("min: [%.4f, %.4f, %.4f]\n", low);
  text += bound("max: [%.4f, %.4f, %.4f]\n", high);
  return text;
}

[[noreturn]] void fail(const fs::path& path) {
  throw FileError("cannot write " + path.string() + "; check the free space and the permissions");
}

void refuse_foreign(const fs::path& directory, const fs::path& file) {
  if (fs::exists(directory / file) && !fs::exists(directory / "map.yaml")) {
    throw FileError((directory / file).string() +
                    " is there already and is no map of this package; name another directory");
  }
}

}  // namespace

Files save_map(const PointCloud& map, const MapDescription& description, const fs::path& directory,
               const std::vector<std::string>& formats) {
  const std::vector<std::string> wanted =
      formats.empty() ? std::vector<std::string>{"pcd", "ply"} : formats;
  for (const std::string& format : wanted) {
    if (format != "pcd" && format != "ply") {
      throw InputError("map format '" + format + "' is not known; use pcd or ply");
    }
    refuse_foreign(directory, "map." + format);
  }
  if (map.empty()) throw InputError("the map has no points yet; drive first");
  check_range(map);
  Files files{directory / "map.yaml"};
  write_text_atomically(files.back(), to_yaml(map, description));
  for (const std::string& format : wanted) {
    files.push_back(directory / ("map." + format));
    format == "pcd" ? write_pcd(files.back(), map) : write_ply(files.back(), map);
  }
  return files;
}

void check_range(const PointCloud& cloud) {
  constexpr float kFarthest = 1e5F;
  for (const Point& point : cloud.points) {
    if (point.position().cwiseAbs().maxCoeff() <= kFarthest) continue;
    throw InputError("the map reaches " +
                     std::to_string(std::lround(point.position().cwiseAbs().maxCoeff())) +
                     " m from the origin of its frame, which PCD and PLY files cannot hold to the "
                     "centimetre; write LAS, or begin the odometry near zero");
  }
}

void write_pcd(const fs::path& path, const PointCloud& cloud) {
  write_atomically(path, [&](const fs::path& temporary) {
    if (pcl::PCDWriter().writeBinaryCompressed(temporary.string(), to_pcl(cloud)) < 0) fail(path);
  });
}

void write_ply(const fs::path& path, const PointCloud& cloud) {
  write_atomically(path, [&](const fs::path& temporary) {
    constexpr bool kBinary = true;
    constexpr bool kWithCamera = false;
    const int result =
        pcl::PLYWriter().write(temporary.string(), to_pcl(cloud), kBinary, kWithCamera);
    // PCL does not notice a full disk.
    if (result != 0 || fs::file_size(temporary) < 16 * cloud.size()) fail(path);
  });
}

}  // namespace lidar_mapping::map
