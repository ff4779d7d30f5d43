// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/map_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <ostream>
#include <vector>

#include <Eigen/Geometry>
#include <pcl/io/lzf.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/pcd_header.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/map/write_products.hpp"

#include "map_formats.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

// Points. Compression needs 33 bytes for each, so 66 MB. Chosen: memory against size of the file.
constexpr std::uint64_t kMaxCompressedPoints = 2'000'000;

struct PointExtent {
  std::uint64_t points = 0;
  Eigen::AlignedBox3f bounds;
};

/// Throws InputError like check_range().
PointExtent extent_of(const CloudParts& map) {
  PointExtent extent;
  map.for_each([&](const PointCloud& part) {
    check_range(part);
    extent.points += part.size();
    for (const Point& point : part.points) extent.bounds.extend(point.position());
  });
  return extent;
}

std::string to_yaml(const PointExtent& extent, const MapDescription& description) {
  const auto bound = [](const char* name, const Eigen::Vector3f& p) {
    return formatted("%s: [%.4f, %.4f, %.4f]\n", name, static_cast<double>(p.x()),
                     static_cast<double>(p.y()), static_cast<double>(p.z()));
  };
  std::string text = "# Map in metres, x east, y north, z up where there is a datum.\n";
  text += "frame: " + (description.utm ? std::string("utm") : description.frame) + "\n";
  if (description.utm) {
    const Eigen::Vector3d& origin = description.utm->origin();
    text += "epsg: " + std::to_string(description.utm->epsg()) + "\n";
    text += formatted("utm_origin: [%.6f, %.6f, %.6f]\n", origin.x(), origin.y(), origin.z());
  }
  if (description.datum) {
    text += formatted("datum: {latitude: %.10f, longitude: %.10f, altitude: %.4f}\n",
                      description.datum->latitude_deg, description.datum->longitude_deg,
                      description.datum->altitude_m);
  } else {
    text += "datum: null\n";
  }
  text += formatted("resolution: %.6g\n", description.resolution);
  text += "points: " + std::to_string(extent.points) + "\n";
  text += bound("min", extent.bounds.min());
  text += bound("max", extent.bounds.max());
  return text;
}

/// All x, then all y, z and intensities: similar values side by side are compressed best.
std::vector<float> values_by_field(const CloudParts& map, std::size_t points) {
  std::vector<float> values(4 * points);
  std::size_t i = 0;
  map.for_each_point([&](const Point& point) {
    values[i] = point.x;
    values[points + i] = point.y;
    values[2 * points + i] = point.z;
    values[3 * points + i] = point.intensity;
    ++i;
  });
  return values;
}

/// Compressed size, original size and the compressed values, as in a PCD file.
std::vector<char> lzf_compressed(const std::vector<float>& values) {
  const auto bytes = static_cast<std::uint32_t>(values.size() * sizeof(float));
  std::array<std::uint32_t, 2> sizes = {0, bytes};
  const std::uint32_t capacity = bytes + bytes / 16 + 64;  // incompressible data grow a little
  std::vector<char> result(sizeof sizes + capacity);
  sizes[0] = pcl::lzfCompress(values.data(), bytes, result.data() + sizeof sizes, capacity);
  std::memcpy(result.data(), sizes.data(), sizeof sizes);
  result.resize(sizeof sizes + sizes[0]);
  return result;
}

/// Writes the same file as PCL's writer with half of its memory.
void write_compressed_pcd(const fs::path& path, const CloudParts& map, std::size_t points) {
  const std::vector<char> data = lzf_compressed(values_by_field(map, points));
  write_stream_atomically(path, [&](std::ostream& file) {
    file << pcd_header(points, "binary_compressed");
    file.write(data.data(), static_cast<std::streamsize>(data.size()));
  });
}

/// Writes a header, followed by the points as they are in memory.
void write_header_and_points(const fs::path& path, const std::string& header,
                             const CloudParts& map) {
  static_assert(sizeof(Point) == 16);
  write_stream_atomically(path, [&](std::ostream& file) {
    file << header;
    map.for_each([&](const PointCloud& part) {
      file.write(reinterpret_cast<const char*>(part.points.data()),
                 static_cast<std::streamsize>(part.size() * sizeof(Point)));
    });
  });
}

/// Writes the origin beside a file in UTM, with the name that hdl_graph_slam uses; removes it
/// beside a file in the map frame.
void write_utm_origin(const fs::path& file, const std::optional<UtmFrame>& utm) {
  const fs::path path = file.string() + ".utm";
  if (!utm) {
    fs::remove(path);
    return;
  }
  const Eigen::Vector3d& origin = utm->origin();
  write_text_atomically(path, formatted("%.6f %.6f %.6f\n", origin.x(), origin.y(), origin.z()));
}

/// Writer of a format that holds points alone; null for other formats.
auto points_writer(const std::string& name) {
  const MapFormat* format = find_format(name);
  return format == nullptr ? nullptr : format->write_points;
}

/// Text of a file; empty if there is none.
std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void check_own_file(const fs::path& file, const fs::path& description) {
  if (fs::exists(file) && !fs::exists(description)) {
    throw FileError(file.string() +
                    " is there already and is no map of this package; name another directory");
  }
}

}  // namespace

Files write_point_files(const CloudParts& map, const MapDescription& description,
                        const fs::path& directory, const std::vector<std::string>& formats,
                        const ConcurrentTask& concurrent_task) {
  const std::vector<std::string> selected_formats =
      formats.empty() ? std::vector<std::string>{"pcd", "ply"} : formats;
  const fs::path description_file = directory / (description.name + ".yaml");
  const auto file_of = [&](const std::string& format) {
    return directory / (description.name + "." + format);
  };
  for (const std::string& format : selected_formats) {
    if (points_writer(format) == nullptr) {
      throw InputError("map format '" + format + "' cannot be written from points alone");
    }
  }
  // Those of other formats, too: the description will stand beside them.
  for (const std::string& format : point_formats()) {
    check_own_file(file_of(format), description_file);
  }
  const PointExtent extent = extent_of(map);
  if (extent.points == 0) throw InputError("the map has no points yet; drive first");
  Files files{description_file};
  const std::string text = to_yaml(extent, description);
  if (text != content_of(description_file)) {
    // They hold what the old description says.
    for (const std::string& format : point_formats()) {
      if (contains(selected_formats, format)) continue;
      fs::remove(file_of(format));
      fs::remove(file_of(format + ".utm"));
    }
  }
  write_text_atomically(files.back(), text);
  const auto write = [&] {
    for (const std::string& format : selected_formats) {
      const fs::path& file = files.emplace_back(file_of(format));
      points_writer(format)(file, map);
      write_utm_origin(file, description.utm);
      if (description.utm) files.push_back(file_of(format + ".utm"));
    }
  };
  parallel_chunks(concurrent_task.work ? 2 : 1, 1, concurrent_task.threads,
                  [&](std::size_t i, std::size_t) { i == 0 ? write() : concurrent_task.work(); });
  return files;
}

void check_range(const PointCloud& cloud) {
  // m. Chosen: the spacing of floats is 8 mm there and doubles beyond.
  constexpr float kMaxDistance = 1e5F;
  for (const Point& point : cloud.points) {
    if (point.position().cwiseAbs().maxCoeff() <= kMaxDistance) continue;
    throw InputError("the map reaches " +
                     std::to_string(std::lround(point.position().cwiseAbs().maxCoeff())) +
                     " m from the origin of its frame, which the floats of this format cannot hold "
                     "to the centimetre; write LAS, or begin the odometry near zero");
  }
}

void write_pcd(const fs::path& path, const CloudParts& map) {
  const std::uint64_t points = extent_of(map).points;
  if (points <= kMaxCompressedPoints) {
    write_compressed_pcd(path, map, points);
    return;
  }
  write_header_and_points(path, pcd_header(points), map);
}

void write_ply(const fs::path& path, const CloudParts& map) {
  write_header_and_points(path,
                          "ply\nformat binary_little_endian 1.0\nelement vertex " +
                              std::to_string(extent_of(map).points) +
                              "\nproperty float x\nproperty float y\nproperty float z\n"
                              "property float intensity\nend_header\n",
                          map);
}

PointCloud in_map_frame(const MapTile& tile) {
  PointCloud cloud = tile.cloud;
  for (Point& point : cloud.points) {
    point.x = static_cast<float>(static_cast<double>(point.x) + tile.origin.x());
    point.y = static_cast<float>(static_cast<double>(point.y) + tile.origin.y());
  }
  check_range(cloud);
  return cloud;
}

}  // namespace lidar_mapping::map
