#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include <Eigen/Geometry>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_products.hpp"

#include "local_ground.hpp"

namespace lidar_mapping::map {

namespace {

// What map_server takes for occupied, free and unknown.
constexpr std::uint8_t kOccupied = 0;
constexpr std::uint8_t kFree = 254;
constexpr std::uint8_t kUnknown = 205;

constexpr std::size_t kBandCells = 16'000'000;  // in memory at a time
constexpr float kGroundMargin = 2.0F;           // m; the ground of a band needs so much around it

/// Where the grid lies; rows are counted from below.
struct Frame {
  Frame(const CloudParts& map, double cell_size) : cell(cell_size) {
    Eigen::AlignedBox2f bounds;
    map.each([&](const PointCloud& part) {
      for (const Point& point : part.points) bounds.extend(point.position().head<2>());
    });
    if (bounds.isEmpty()) throw InputError("the map has no points; there is no grid to make");
    x_min = cell * std::floor(static_cast<double>(bounds.min().x()) / cell);
    y_min = cell * std::floor(static_cast<double>(bounds.min().y()) / cell);
    columns = column_of(bounds.max().x()) + 1;
    rows = row_of(bounds.max().y()) + 1;
  }

  int column_of(float x) const { return static_cast<int>((static_cast<double>(x) - x_min) / cell); }
  int row_of(float y) const { return static_cast<int>((static_cast<double>(y) - y_min) / cell); }

  std::string yaml() const {
    char text[256];
    std::snprintf(text, sizeof text,
                  "image: grid.pgm\nresolution: %.9g\norigin: [%.6f, %.6f, 0.0]\nnegate: 0\n"
                  "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                  cell, x_min, y_min);
    return text;
  }

  double cell;
  double x_min = 0.0;
  double y_min = 0.0;
  int columns = 0;
  int rows = 0;
};

/// The rows [begin, end) of the grid.
class Band {
 public:
  Band(const Frame& frame, int begin, int end)
      : frame_(frame),
        begin_(begin),
        end_(end),
        obstacles_(static_cast<std::size_t>(frame.columns) * static_cast<std::size_t>(end - begin)),
        ground_(obstacles_.size()) {}

  void fill(const CloudParts& map, const GridOptions& options) {
    constexpr float kAll = std::numeric_limits<float>::infinity();
    const PointCloud cloud = points_around(map);
    const PlacedPoints points(cloud, Pose());
    const GroundArea area(points, kAll);
    LocalGround ground(area);
    ground.add(ground_columns(points, kAll));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int row = frame_.row_of(cloud.points[i].y);
      if (row < begin_ || row >= end_) continue;
      const float z = static_cast<float>(points.origin.z()) + points.z[i];
      add(at(row, frame_.column_of(cloud.points[i].x)), ground.height_above(z, area.column_of(i)),
          options);
    }
  }

  /// Pixels, the uppermost row first.
  std::string pixels(const GridOptions& options) const {
    std::string text;
    text.reserve(obstacles_.size());
    for (int row = end_ - 1; row >= begin_; --row) {
      for (int column = 0; column < frame_.columns; ++column) {
        const std::size_t i = at(row, column);
        const std::uint8_t value = obstacles_[i] >= options.min_points ? kOccupied
                                   : ground_[i] != 0                   ? kFree
                                                                       : kUnknown;
        text += static_cast<char>(value);
      }
    }
    return text;
  }

 private:
  PointCloud points_around(const CloudParts& map) const {
    const auto y_of = [&](int row) { return static_cast<float>(frame_.y_min + row * frame_.cell); };
    const float low = y_of(begin_) - kGroundMargin;
    const float high = y_of(end_) + kGroundMargin;
    PointCloud cloud;
    map.each([&](const PointCloud& part) {
      for (const Point& point : part.points) {
        if (point.y >= low && point.y <= high) cloud.points.push_back(point);
      }
    });
    return cloud;
  }

  std::size_t at(int row, int column) const {
    return static_cast<std::size_t>(row - begin_) * static_cast<std::size_t>(frame_.columns) +
           static_cast<std::size_t>(column);
  }

  void add(std::size_t cell, float height, const GridOptions& options) {
    if (static_cast<double>(height) < options.lowest) {
      ground_[cell] = 1;
    } else if (static_cast<double>(height) <= options.highest) {
      ++obstacles_[cell];
    }
  }

  const Frame& frame_;
  int begin_;
  int end_;
  std::vector<int> obstacles_;
  std::vector<char> ground_;
};

}  // namespace

Files save_grid(const CloudParts& map, const GridOptions& options,
                const std::filesystem::path& directory) {
  const Frame frame(map, options.cell);
  const Files files = {directory / "grid.pgm", directory / "grid.yaml"};
  const int rows = static_cast<int>(
      std::max<std::size_t>(1, kBandCells / static_cast<std::size_t>(frame.columns)));
  write_atomically(files[0], [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file << "P5\n" << frame.columns << " " << frame.rows << "\n255\n";
    for (int end = frame.rows; end > 0; end -= rows) {
      Band band(frame, std::max(0, end - rows), end);
      band.fill(map, options);
      file << band.pixels(options);
    }
    file.close();
    if (!file) throw FileError("cannot write " + files[0].string() + "; check the free space");
  });
  write_text_atomically(files[1], frame.yaml());
  return files;
}

}  // namespace lidar_mapping::map
