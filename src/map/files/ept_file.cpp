// SPDX-License-Identifier: BSD-3-Clause
#include "files/ept_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>

#include "lidar_mapping/common/errors.hpp"

#include "files/millimetre_frame.hpp"
#include "json.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;
using json::Json;

constexpr float kMaxIntensity = 65535.0F;  // by LAS: the largest value of 16 bits
// Bytes, by definition: three coordinates, intensity, drive, time, as the schema lists them.
constexpr std::size_t kPointBytes = 3 * 4 + 2 + 2 + 8;

/// Count, extremes and moments of a dimension. Values are summed relative to the first one, so that
/// large coordinates lose nothing.
class Statistics {
 public:
  void add(double value) {
    if (count_ == 0) first_ = value;
    ++count_;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
    sum_ += value - first_;
    squares_ += (value - first_) * (value - first_);
  }
  double high() const { return high_; }

  Json figures(double scale = 1.0) const {
    const auto n = static_cast<double>(count_);
    const double mean = sum_ / n;
    const double variance = std::max(0.0, squares_ / n - mean * mean) * scale * scale;
    return {{"count", count_},
            {"minimum", low_ * scale},
            {"maximum", high_ * scale},
            {"mean", (first_ + mean) * scale},
            {"stddev", std::sqrt(variance)},
            {"variance", variance}};
  }

 private:
  std::size_t count_ = 0;
  double first_ = 0.0;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
  double sum_ = 0.0;
  double squares_ = 0.0;
};

/// The points of a map on their way into the tiles, and what the metadata say of them.
class PointCollector {
 public:
  PointCollector(const EptOptions& options, const fs::path& folder)
      : options_(options), frame_(options.datum), points_(folder) {}

  void add(const MapTile& tile) {
    if (is_empty()) frame_.set_offset_near(tile.origin);
    for (std::size_t i = 0; i < tile.cloud.size(); ++i) {
      const Point& point = tile.cloud.points[i];
      add({frame_.millimetres(frame_.projected(tile.origin + point.position().cast<double>())),
           point.intensity, tile.key_frames.empty() ? KeyFrameIndex{0} : tile.key_frames[i]});
    }
  }

  bool is_empty() const { return points_.size() == 0; }
  std::size_t size() const { return points_.size(); }
  const std::array<std::int32_t, 3>& low() const { return low_; }
  const std::array<std::int32_t, 3>& high() const { return high_; }
  const MillimetreFrame& frame() const { return frame_; }
  PointSpool take_points() { return std::move(points_); }
  /// The factor from intensities of the sensor to those of the file.
  float intensity_scale() const {
    const auto largest = static_cast<float>(intensity_.high());
    return largest > 0.0F ? kMaxIntensity / largest : 1.0F;
  }

  /// A coordinate of millimetres along an axis in m: the quotient of two whole numbers, so that its
  /// text has no more than three decimals.
  double metres(std::size_t axis, double millimetres) const {
    constexpr double kPerMetre = 1000.0;  // mm, by definition
    return (frame_.offset()[static_cast<Eigen::Index>(axis)] * kPerMetre + millimetres) / kPerMetre;
  }

  Json schema() const {
    Json dimensions = Json::array();
    for (std::size_t i = 0; i < 3; ++i) {
      Json dimension = {{"name", std::string(1, "XYZ"[i])},
                        {"type", "signed"},
                        {"size", 4},
                        {"scale", kMillimetre},
                        {"offset", frame_.offset()[static_cast<Eigen::Index>(i)]}};
      dimension.update(position_[i].figures());
      dimensions.push_back(dimension);
    }
    const auto add = [&](const char* name, const char* type, int size, const Json& figures) {
      Json dimension = {{"name", name}, {"type", type}, {"size", size}};
      dimension.update(figures);
      dimensions.push_back(dimension);
    };
    add("Intensity", "unsigned", 2, intensity_.figures(static_cast<double>(intensity_scale())));
    add("PointSourceId", "unsigned", 2, drive_.figures());
    add("GpsTime", "float", 8, time_.figures());
    return dimensions;
  }

 private:
  void add(const StoredPoint& point) {
    for (std::size_t i = 0; i < 3; ++i) {
      low_[i] = std::min(low_[i], point.position[i]);
      high_[i] = std::max(high_[i], point.position[i]);
      position_[i].add(metres(i, point.position[i]));
    }
    const PointOrigin origin = options_.origin(point.key_frame);
    intensity_.add(static_cast<double>(point.intensity));
    drive_.add(origin.drive);
    time_.add(to_seconds(origin.stamp));
    points_.add(point);
  }

  const EptOptions& options_;
  MillimetreFrame frame_;
  PointSpool points_;
  std::array<std::int32_t, 3> low_ = {INT32_MAX, INT32_MAX, INT32_MAX};
  std::array<std::int32_t, 3> high_ = {INT32_MIN, INT32_MIN, INT32_MIN};
  std::array<Statistics, 3> position_;
  Statistics intensity_;
  Statistics drive_;
  Statistics time_;
};

/// Without a temporary name: the whole folder gets its name at the end.
void write_file(const fs::path& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << content;
  file.close();
  if (!file) throw FileError("cannot write " + path.string() + "; check the free space");
}

template <typename Number>
char* put(char* to, Number number) {
  std::memcpy(to, &number, sizeof number);
  return to + sizeof number;
}

/// Writes ept-data, and counts the points of each node.
class NodeWriter {
 public:
  NodeWriter(const EptOptions& options, float intensity_scale, fs::path folder)
      : options_(options), intensity_scale_(intensity_scale), folder_(std::move(folder)) {
    fs::create_directories(folder_);
  }

  void operator()(const OctreeKey& key, const std::vector<StoredPoint>& points) {
    write_file(folder_ / (key.name() + ".bin"), encoded(points));
    const std::lock_guard<std::mutex> lock(mutex_);
    counts_[key] = points.size();
  }

  const std::map<OctreeKey, std::size_t>& counts() const { return counts_; }

 private:
  /// In the byte order of the format, which is little endian like every processor that this runs
  /// on.
  std::string encoded(const std::vector<StoredPoint>& points) const {
    std::string data(kPointBytes * points.size(), '\0');
    char* to = data.data();
    for (const StoredPoint& point : points) {
      for (const std::int32_t coordinate : point.position) to = put(to, coordinate);
      const float intensity = std::clamp(point.intensity * intensity_scale_, 0.0F, kMaxIntensity);
      const PointOrigin origin = options_.origin(point.key_frame);
      to = put(to, static_cast<std::uint16_t>(std::lround(intensity)));
      to = put(to, origin.drive);
      to = put(to, to_seconds(origin.stamp));
    }
    return data;
  }

  const EptOptions& options_;
  const float intensity_scale_;
  const fs::path folder_;
  std::mutex mutex_;
  std::map<OctreeKey, std::size_t> counts_;
};

/// The number of points of each node, in one file, or where there are many nodes in one for each
/// subtree; a reader finds -1 where another file goes on.
class Hierarchy {
 public:
  Hierarchy(const std::map<OctreeKey, std::size_t>& counts, fs::path folder)
      : counts_(counts), folder_(std::move(folder)) {
    fs::create_directories(folder_);
  }

  void write(const OctreeKey& root) const {
    Json nodes = Json::object();
    collect(root, root.depth, nodes);
    write_file(folder_ / (root.name() + ".json"), json::dumped(nodes) + "\n");
  }

 private:
  void collect(const OctreeKey& key, int depth_of_file, Json& nodes) const {
    // Levels. Chosen: up to some thousand nodes of a surface, 100 kB.
    constexpr int kLevelsOfFile = 6;
    const auto found = counts_.find(key);
    if (found == counts_.end()) return;
    if (key.depth == depth_of_file + kLevelsOfFile && has_children(key)) {
      nodes[key.name()] = -1;
      return write(key);
    }
    nodes[key.name()] = found->second;
    for (unsigned octant = 0; octant < 8; ++octant) {
      collect(key.child(octant), depth_of_file, nodes);
    }
  }

  bool has_children(const OctreeKey& key) const {
    for (unsigned octant = 0; octant < 8; ++octant) {
      if (counts_.count(key.child(octant)) > 0) return true;
    }
    return false;
  }

  const std::map<OctreeKey, std::size_t>& counts_;
  const fs::path folder_;
};

Json system_of(const MillimetreFrame& frame) {
  if (frame.epsg() == 0) return Json::object();
  return {{"authority", "EPSG"},
          {"horizontal", std::to_string(frame.epsg())},
          {"wkt", utm_wkt(frame.epsg())}};
}

Json metadata(const PointCollector& points, const OctreeCube& cube) {
  Json bounds = Json::array();
  Json conforming = Json::array();
  for (std::size_t i = 0; i < 3; ++i) {
    bounds.push_back(points.metres(i, static_cast<double>(cube.corner[i])));
    conforming.push_back(points.metres(i, points.low()[i]));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    bounds.push_back(points.metres(i, static_cast<double>(cube.corner[i] + cube.edge)));
    conforming.push_back(points.metres(i, points.high()[i]));
  }
  return {{"bounds", bounds},
          {"boundsConforming", conforming},
          {"dataType", "binary"},
          {"hierarchyType", "json"},
          {"points", points.size()},
          {"schema", points.schema()},
          {"span", OctreeOptions::kSpan},
          {"srs", system_of(points.frame())},
          {"version", "1.0.0"}};
}

}  // namespace

void write_ept(const TileSource& tiles, const EptOptions& options, const fs::path& folder) {
  PointCollector points(options, folder);
  tiles([&](const MapTile& tile) { points.add(tile); });
  if (points.is_empty()) throw InputError("the map has no points yet; drive first");
  const OctreeCube cube(points.low(), points.high());
  const Json description = metadata(points, cube);
  NodeWriter nodes(options, points.intensity_scale(), folder / "ept-data");
  divide_into_octree(points.take_points(), cube, options.octree, folder, std::ref(nodes));
  Hierarchy(nodes.counts(), folder / "ept-hierarchy").write({});
  write_file(folder / "ept.json", json::dumped(description, 2) + "\n");
}

}  // namespace lidar_mapping::map
